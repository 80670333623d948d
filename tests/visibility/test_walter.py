"""Walter's fit: as published, as far off as stated, and nowhere in use."""

from __future__ import annotations

import re
from pathlib import Path

import microfacet as mf
import numpy as np
import pytest
import sympy as sp
from microfacet.statements import checks
from microfacet.visibility import walter
from references import beckmann_Lambda

LIBRARY = Path(mf.__file__).parent
FIT = mf.equations["visibility.beckmann.walter"]


def test_the_fit_is_the_published_one() -> None:
    a = np.linspace(0.01, 1.59, 50)
    published = (3.535 * a + 2.181 * a * a) / (1 + 2.276 * a + 2.577 * a * a)
    np.testing.assert_allclose(FIT.kernel(a), published, rtol=1e-14)


def test_the_error_is_as_large_as_stated_and_no_larger() -> None:
    """0.31 % near a = 1.34; G1 above 1 between 1.548 and 1.6."""
    a = np.linspace(0.002, 1.6, 800)
    exact = np.array([1 / (1 + float(beckmann_Lambda(x))) for x in a])
    off = np.abs(FIT.kernel(a) / exact - 1)
    assert off.max() == pytest.approx(0.003127, abs=1e-6)
    assert off.max() < float(walter.error.equals) < off.max() + 1e-4
    assert a[off.argmax()] == pytest.approx(1.336, abs=0.01)
    assert ((FIT.kernel(a) > 1) == (a > 1.5482)).all()


def test_the_printed_ratio_is_that_of_the_statements() -> None:
    stated = walter.fit.equals * (1 + mf.equations["geometry.beckmann.Lambda"].equals)
    assert checks.vanishes(sp.simplify(stated.doit() - walter.ratio()))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("key", "value"), [("walter_error", sp.Rational(31, 10000)), ("walter_above", sp.Rational(10002, 10000))]
)
def test_a_bound_that_is_too_tight_is_red(monkeypatch: pytest.MonkeyPatch, key: str, value: sp.Rational) -> None:
    pytest.importorskip("flint")
    statement = mf.equations[f"visibility.beckmann.{key}"]
    assert checks.enclosed(statement).status == "pass"
    monkeypatch.setitem(statement.__dict__, "equals", value)
    assert checks.enclosed(statement).status == "fail"


def test_no_model_uses_it() -> None:
    users = [path.name for path in LIBRARY.rglob("*.py") if re.search(r"\bwalter\b(?!2007)", path.read_text())]
    assert users == ["walter.py"]
