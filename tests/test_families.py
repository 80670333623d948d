"""A family in one file has its place in every list: the README's example, and classes that inherit all they can do."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import microfacet as mf
import pytest
import samples
from microfacet.enough.candidates import maskings
from microfacet.enough.scene import normals_by_name
from microfacet.families import families, key_of, of_alpha
from microfacet.geometry.slopes import Distribution
from microfacet.material.fresnel import Fresnel
from microfacet.validation import accuracy_table
from microfacet.visibility.masking import Masking
from report import tables

ROOT = Path(__file__).resolve().parents[1]
README = (ROOT / "README.md").read_text("utf-8")

OUTSIDE = """
import json
from microfacet.families import families
from microfacet.enough.candidates import candidates_for, maskings
from microfacet.enough.scene import Scene, normals_by_name
from microfacet.material.fresnel import Fresnel
from microfacet.statements.statement import Equation
from microfacet.validation import accuracy_table
from report import quantifiers, tables
import sympy

class Twin(mf.GGX):
    label = "twin"

class Other(mf.Implicit):
    label = "other"

class Tinted(mf.Schlick):
    label = "tinted"

def kernel_square(cosine, p):
    return cosine * cosine

c = sympy.Symbol("c", positive=True)
square = Equation(key="zoo.square.F", title="", symbol=sympy.Symbol("z"), equals=c**2, over={c: (0.01, 1)})

class Square(mf.Fresnel):
    label = "square"
    statements = {"F": square}
    parameters = ()
    kernel = staticmethod(kernel_square)

import samples

scene = Scene(0.3, normals="steep", bounces="one", fresnel=Tinted(0.5))
stated = Equation(key="zoo.steep.D", title="", symbol=sympy.Symbol("z"), equals=sympy.Integer(1))
print(json.dumps({
    "table 1": [kind.__name__ for kind in tables.distributions()],
    "table 2": [*tables.maskings()],
    "proved": quantifiers.quantifiers()["steep"].brief,
    "trust": [kind.__name__ for kind in accuracy_table.stated_families()],
    "chooser": [*normals_by_name()],
    "candidates": sorted({(one.normals, one.masking) for one in candidates_for(scene)}),
    "told": str(scene),
    "walk": mf.RandomWalk(mf.Smith(Twin(0.3))).single is not None,
    "fresnel": [kind.__name__ for kind in families(Fresnel)],
    "digits": [float(min(accuracy_table.further_parts()["`Square.F`"](real))) for real in accuracy_table.PRECISIONS],
    "tests": [repr(ndf) for ndf in samples.NORMALISED],
    "stretched": [kind.__name__ for kind in samples.STRETCHED],
    "last statement": [*mf.equations][-1],
}))
"""


@pytest.fixture(scope="module")
def lists(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What a process with such a file finds in each list."""
    example = next(block for block in re.findall(r"^```python\n(.*?)^```", README, re.M | re.S) if "class Steep" in block)
    lines = [line[4:] for line in example.splitlines() if line.startswith((">>>", "..."))]
    definitions = "\n".join(lines[: next(k for k, line in enumerate(lines) if line.startswith("mf.validate"))])
    file = tmp_path_factory.mktemp("outside") / "steep.py"
    file.write_text(definitions + OUTSIDE, "utf-8")
    paths = os.pathsep.join(str(ROOT / folder) for folder in ("lib", "tests/support"))
    done = subprocess.run(
        [sys.executable, str(file)], env=os.environ | {"PYTHONPATH": paths}, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return dict(json.loads(done.stdout))


def test_the_readmes_distribution_is_in_the_first_table(lists: dict[str, Any]) -> None:
    assert lists["table 1"] == ["BlinnPhong", "NormalizedBlinnPhong", "Ward", "Beckmann", "GGX", "Steep", "Twin"]
    assert lists["proved"] == "–"


def test_a_masking_function_is_in_the_second_table_and_among_the_candidates(lists: dict[str, Any]) -> None:
    assert lists["table 2"][-2:] == ["Schlick-Smith, halved", "other"]
    assert ["steep", "other"] in lists["candidates"]


def test_what_states_D_and_Lambda_is_in_the_domain_of_trust(lists: dict[str, Any]) -> None:
    assert lists["trust"] == ["GGX", "Beckmann", "Twin"]


def test_the_chooser_knows_it(lists: dict[str, Any]) -> None:
    assert lists["chooser"] == ["ggx", "beckmann", "ward", "steep", "twin"]
    assert lists["told"] == "Steep, tinted 0.5 + 1i, alpha 0.3, views 0 to 80 degrees, one bounce"
    assert lists["walk"]


def test_a_fresnel_term_is_a_family(lists: dict[str, Any]) -> None:
    assert lists["fresnel"][-2:] == ["Tinted", "Square"]


def test_a_fresnel_term_that_is_stated_is_in_the_domain_of_trust(lists: dict[str, Any]) -> None:
    double, single = lists["digits"]
    assert double > 15
    assert 6 < single < 8


def test_the_tests_have_it_in_their_lists(lists: dict[str, Any]) -> None:
    assert {"Steep(0.4)", "Twin(0.4, 0.4)"} <= set(lists["tests"])
    assert lists["stretched"] == ["Beckmann", "GGX", "Ward", "Twin"]


def test_a_statement_of_a_new_stage_comes_last(lists: dict[str, Any]) -> None:
    assert lists["last statement"] == "zoo.steep.D"


def test_a_statement_where_none_is_looked_for_is_refused() -> None:
    code = "from microfacet.statements.statement import Equation\nEquation(key='enough.a.b', title='', symbol=None, equals=1)"
    with pytest.raises(ValueError, match=r"equation enough\.a\.b stands in enough/, where none is looked for, but in geometry"):
        exec(code, {"__name__": "microfacet.enough.more"})


def test_a_key_names_the_folder_that_its_statement_stands_in() -> None:
    for key, equation in mf.equations.items():
        library, folder = equation.stated_at.split(".")[:2]
        assert library != "microfacet" or key.startswith(f"{folder}."), key
    code = "from microfacet.statements.statement import Equation\nEquation(key='brdf.a.b', title='', symbol=None, equals=1)"
    with pytest.raises(ValueError, match=r"equation brdf\.a\.b stands in material/: its key must begin with material\."):
        exec(code, {"__name__": "microfacet.material.more"})


def test_the_library_has_its_families_in_every_list() -> None:
    ndfs = {kind.__name__ for kind in families(Distribution) if kind.__module__.startswith("microfacet.")}
    assert ndfs <= {kind.__name__ for kind in tables.distributions()}
    assert ndfs <= {kind.__name__ for kind in samples.FAMILIES}
    assert {kind.__name__ for kind in normals_by_name().values()} >= ndfs - {"BlinnPhong", "NormalizedBlinnPhong"}
    assert {kind.label for kind in families(Masking)} <= tables.maskings().keys()
    assert {"implicit", "v_cavity"} <= maskings().keys()
    assert [kind.__name__ for kind in accuracy_table.stated_families()][:2] == ["GGX", "Beckmann"]
    assert mf.Conductor in families(Fresnel)


def test_classes_without_a_label_are_in_no_list() -> None:
    class Quiet(mf.GGX):
        """Its base has a label; it has none of its own."""

    assert Quiet not in families(Distribution)


@pytest.mark.parametrize(
    ("kind", "key"), [(mf.GGX, "ggx"), (mf.NormalizedBlinnPhong, "normalized_blinn_phong"), (mf.VCavity, "v_cavity")]
)
def test_keys_are_those_of_the_statements(kind: type[Any], key: str) -> None:
    assert key_of(kind) == key
    assert any(f".{key}." in known for known in mf.equations)


def test_one_roughness_is_not_two() -> None:
    assert of_alpha(mf.GGX, 0.3, 0.1) == mf.GGX(0.3, 0.1)

    class Round(mf.GGX):
        def __init__(self, alpha: float) -> None:
            super().__init__(alpha)

    assert of_alpha(Round, 0.3, 0.3) == Round(0.3)
    with pytest.raises(ValueError, match=r"Round has one roughness, got 0\.3 and 0\.1"):
        of_alpha(Round, 0.3, 0.1)
