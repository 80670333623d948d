"""The promised error of every kernel, sought out: many times as many arguments as the gate tries, and others near the worst."""

from __future__ import annotations

import zlib

import microfacet as mf
import numpy as np
import pytest
from microfacet.statements import checks
from microfacet.statements.statement import Equation

COMPUTED = [key for key in mf.equations if checks.is_computed(mf.equations[key])]


@pytest.mark.slow
@pytest.mark.parametrize("real", [np.float64, np.float32])
@pytest.mark.parametrize("key", COMPUTED)
def test_no_argument_is_found_where_a_kernel_breaks_its_promise(key: str, real: type, monkeypatch: pytest.MonkeyPatch) -> None:
    def other_seed(equation: Equation) -> np.random.Generator:
        return np.random.default_rng(zlib.crc32(f"another seed for {equation.key}".encode()))

    monkeypatch.setattr(checks, "_random", other_seed)
    monkeypatch.setattr(checks, "POINTS", 4000)
    monkeypatch.setattr(checks, "ROUNDS", 40)
    error, where = checks.worst_error(mf.equations[key], real)
    assert error <= mf.equations[key].within[real is np.float32], where


def test_the_search_finds_a_larger_error_near_the_worst_of_the_first_arguments(monkeypatch: pytest.MonkeyPatch) -> None:
    equation = mf.equations["geometry.blinn_phong.H"]
    found = {}
    for rounds in (0, 40):
        monkeypatch.setattr(checks, "ROUNDS", rounds)
        found[rounds] = checks.worst_error(equation, np.float64)[0]
    assert found[40] > 1.2 * found[0]
    assert found[0] > 0


def test_arguments_near_others_are_in_the_domain_and_as_near_as_an_ulp() -> None:
    for key in ("geometry.ggx.D", "geometry.blinn_phong.H", "brdf.microfacet.ggx", "material.fresnel.conductor"):
        equation = mf.equations[key]
        for real in (np.float64, np.float32):
            points = checks.sample(equation, real)
            moved = checks.near(equation, points, np.random.default_rng(5))
            assert moved.dtype == real
            again = checks.near(equation, moved, np.random.default_rng(6))
            for points_ in (moved, again):
                at = 0
                for argument, domain in equation.over.items():
                    if isinstance(domain, str):
                        length = np.linalg.norm(points_[:, at : at + 3].astype(float), axis=1)
                        assert np.allclose(length, 1, atol=4 * np.finfo(real).eps)
                        at += 3
                    else:
                        assert (points_[:, at] >= float(domain[0])).all(), argument
                        assert (points_[:, at] <= float(domain[1])).all(), argument
                        at += 1
            changed = moved != points
            apart = np.abs(moved.astype(float) - points)[changed] / np.abs(points[changed])
            assert np.quantile(apart, 0.01) < 100 * np.finfo(real).eps
            assert 0.01 < apart.max() < 1
