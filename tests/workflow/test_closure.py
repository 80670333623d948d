"""The import closure: everything a script needs, and nothing that it does not."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import closure
import pytest
from checkout import ROOT, Checkout

MODULES = {
    "__init__.py": 'import importlib\nPUBLIC = {"GGX": "geometry.ggx", "equations": "statement"}\n',
    "notation.py": "x = 1\n",
    "statement.py": "import importlib\nfrom .notation import x\n\nclass Equation: ...\n\nclass All:\n"
    "    def load(self): importlib.import_module('microfacet.' + 'x')\n\nequations = All()\n",
    "geometry/__init__.py": "",
    "geometry/slopes.py": "from microfacet.statement import Equation\n",
    "geometry/ggx.py": "from . import slopes\n",
    "visibility/__init__.py": "",
    "visibility/smith.py": "def f():\n    from ..geometry import ggx\n",
}
GGX = {"geometry/__init__.py", "geometry/ggx.py", "geometry/slopes.py", "statement.py", "notation.py"}


@pytest.fixture
def library(small: Checkout) -> Path:
    package = small.path("lib/microfacet")
    for name, text in MODULES.items():
        package.joinpath(name).parent.mkdir(exist_ok=True)
        package.joinpath(name).write_text(text)
    for extra in {str(p.relative_to(package)) for p in package.rglob("*.py")} - set(MODULES):
        package.joinpath(extra).unlink()
    return package


@pytest.mark.parametrize(
    ("source", "needs"),
    [
        ("import numpy", set()),
        ("import microfacet as mf", set()),
        ("import microfacet as mf\nmf.GGX(0.3)", GGX),
        ("import microfacet\nmicrofacet.GGX(0.3)", GGX),
        ("from microfacet import GGX", GGX),
        ("from microfacet.notation import x", {"notation.py"}),
        ("from microfacet import notation", {"notation.py"}),
        ("import microfacet.notation as n\nn.x", {"notation.py"}),
        ("import microfacet as mf\nmf.geometry.slopes.Equation", GGX - {"geometry/ggx.py"}),
        ("from microfacet.visibility import smith", {"visibility/__init__.py", "visibility/smith.py"}),
        ("from microfacet.visibility import smith\nsmith.f()", GGX | {"visibility/__init__.py", "visibility/smith.py"}),
        ("from microfacet.visibility.smith import f", GGX | {"visibility/__init__.py", "visibility/smith.py"}),
        ("def draw():\n    from microfacet.notation import x", {"notation.py"}),
        ("from microfacet.statement import Equation", {"statement.py", "notation.py"}),
        ("import microfacet as mf\nmf.equations['k']", set(MODULES)),
        ("import microfacet as mf\nprint(mf)", set(MODULES)),
        ("from microfacet import *", set(MODULES)),
    ],
)
def test_closure_of_a_source(library: Path, source: str, needs: set[str]) -> None:
    found = closure.of_source(source)
    assert {str(path.relative_to("lib/microfacet")) for path in found} == needs


def test_a_helper_beside_a_script_counts(small: Checkout) -> None:
    small.path("figures/visibility/helper.py").write_text("from microfacet.geometry import ggx\n")
    small.path("figures/visibility/drawing.py").write_text("import helper\n")
    assert closure.of_script(Path("figures/visibility/drawing.py")) == [
        "figures/visibility/helper.py",
        "lib/microfacet/geometry/__init__.py",
        "lib/microfacet/geometry/ggx.py",
    ]


def test_a_helper_of_a_helper_beside_a_script_counts(small: Checkout) -> None:
    small.path("figures/visibility/inner.py").write_text("from microfacet.geometry import ggx\n")
    small.path("figures/visibility/outer.py").write_text("import inner\n")
    small.path("figures/visibility/drawing.py").write_text("import outer\n")
    assert closure.of_script(Path("figures/visibility/drawing.py"))[:2] == [
        "figures/visibility/inner.py",
        "figures/visibility/outer.py",
    ]


LOADED = """
import runpy, sys
runpy.run_path(sys.argv[1], run_name="__main__")
print(*(m.__file__ for n, m in sys.modules.items() if n.startswith("microfacet.")), sep="\\n")
"""


@pytest.mark.slow
@pytest.mark.parametrize("name", ["material/fresnel", "anisotropy/stretching", "anisotropy/alpha_o", "visibility/masking"])
def test_what_a_script_loads_is_in_its_closure(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    script = Path(f"figures/{name}_data.py")
    command = [sys.executable, "-c", LOADED.replace("sys.argv[1]", repr(str(script))), str(tmp_path / "data.npz")]
    done = subprocess.run(command, text=True, check=True, capture_output=True, env=os.environ | {"PYTHONPATH": "lib"})
    loaded = {str(Path(line).resolve().relative_to(ROOT)) for line in done.stdout.split()}
    loaded = {path for path in loaded if path.startswith("lib/")}
    assert len(loaded) >= 2
    assert loaded <= set(closure.of_script(script))
