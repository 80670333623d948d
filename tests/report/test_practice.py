"""Tables for those who write a renderer: numbers against formulas written down once more, and the library."""

from __future__ import annotations

from collections.abc import Iterator

import microfacet as mf
import mpmath
import numpy as np
import pytest
from microfacet.geometry.roughness import CONVENTIONS
from mpmath import mpf
from report import practice


@pytest.fixture(scope="module")
def values() -> dict[str, list[mpf]]:
    found: dict[str, list[mpf]] = {}
    for one in practice.references():
        found.setdefault(one.what, []).append(one.value)
    return found


@pytest.fixture(autouse=True)
def fifty_digits() -> Iterator[None]:
    with mpmath.workdps(60):
        yield


with mpmath.workdps(60):
    X, Y, Z = mpf(48) / 100, mpf(64) / 100, mpf(60) / 100
    ALPHAS = [(mpf(5) / 10, mpf(5) / 10), (mpf(6) / 10, mpf(3) / 10), (mpf(1) / 100, mpf(1) / 100)]


def same(found: list[mpf], expected: list[mpf]) -> bool:
    """To 45 digits, number by number."""
    return all(abs(a / b - 1) < mpf(10) ** -45 for a, b in zip(found, expected, strict=True))


def test_distributions_in_the_textbooks_form(values: dict[str, list[mpf]]) -> None:
    tangents = [((X / ax) ** 2 + (Y / ay) ** 2) / Z**2 for ax, ay in ALPHAS[:2]]
    areas = [mpmath.pi * ax * ay * Z**4 for ax, ay in ALPHAS[:2]]
    assert same(values["$D$ of GGX"], [1 / (area * (1 + t) ** 2) for t, area in zip(tangents, areas, strict=True)])
    assert same(values["$D$ of Beckmann"], [mpmath.exp(-t) / area for t, area in zip(tangents, areas, strict=True)])


def test_Lambda_in_the_textbooks_form(values: dict[str, list[mpf]]) -> None:
    slopes = [mpf(1) / 10, mpf(1), mpf(5)]
    assert same(values[r"$\Lambda$ of GGX"], [(mpmath.sqrt(1 + 1 / a**2) - 1) / 2 for a in slopes])
    closed = [(mpmath.erf(a) - 1) / 2 + mpmath.exp(-(a**2)) / (2 * a * mpmath.sqrt(mpmath.pi)) for a in slopes]
    assert all(abs(a / b - 1) < mpf(10) ** -40 for a, b in zip(values[r"$\Lambda$ of Beckmann"], closed, strict=True))


def test_the_brdf_is_D_G2_over_the_cosines(values: dict[str, list[mpf]]) -> None:
    wi = mpf(-28) / 100, mpf(0), mpf(96) / 100
    sums = [X + wi[0], Y + wi[1], Z + wi[2]]
    x, y, z = [s / mpmath.sqrt(sum(t**2 for t in sums)) for s in sums]
    expected = []
    for ax, ay in ALPHAS:
        D = 1 / (mpmath.pi * ax * ay * ((x / ax) ** 2 + (y / ay) ** 2 + z**2) ** 2)
        Lambdas = [(mpmath.sqrt(1 + ((ax * w[0]) ** 2 + (ay * w[1]) ** 2) / w[2] ** 2) - 1) / 2 for w in ((X, Y, Z), wi)]
        expected.append(D / (1 + sum(Lambdas)) / (4 * Z * wi[2]))
    assert same(values[r"$\rho$ of GGX, $F = 1$"], expected)


def test_reflectances_by_the_amplitudes_of_both_polarisations(values: dict[str, list[mpf]]) -> None:
    c = mpf(1) / 2

    def reflectance(n: mpmath.mpc) -> mpf:
        t = mpmath.sqrt(1 - (1 - c**2) / n**2)
        return (abs((c - n * t) / (c + n * t)) ** 2 + abs((n * c - t) / (n * c + t)) ** 2) / 2

    assert same(values["$F$, dielectric"], [reflectance(mpmath.mpc(mpf(3) / 2))])
    assert same(values["$F$, conductor"], [reflectance(mpmath.mpc(mpf(2) / 10, mpf(39) / 10))])
    assert same(values["$F$, Schlick"], [mpf(4) / 100 + mpf(96) / 100 * c**5])


def test_albedos_are_integrals_of_the_brdf(values: dict[str, list[mpf]]) -> None:
    """At alpha = 1 D is 1/pi, so that what is left is an integral over the light of G2/(4 pi cos), by the closed Lambda."""

    def integrand(mu_o: mpf, mu_i: mpf) -> mpf:
        return 2 * mpmath.pi * mu_i / (2 * mpmath.pi) / (mu_o + mu_i)  # reach 1: Lambda = (1/mu - 1)/2

    with mpmath.workdps(20):
        expected = [mpmath.quad(lambda mu_i, mu=mu: integrand(mu, mu_i), [0, 1]) for mu in (mpf(1) / 10, mpf(6) / 10)]
    found = values[r"albedo of GGX, $\alpha = 1$, $F = 1$"]
    assert list(map(float, found)) == pytest.approx(list(map(float, expected)), 1e-12)


def test_digits_are_printed_and_kernels_keep_them() -> None:
    for one in practice.references():
        printed = one.row[2].strip("$").replace(r" \cdot 10^{", "e").rstrip("}")
        assert abs(mpf(printed) / one.value - 1) < mpf(10) ** -14
        assert len(printed.split("e")[0].replace(".", "").lstrip("0")) == practice.DIGITS
        assert max(one.ulps) < 24


def test_ulps_count_a_wrong_kernel(monkeypatch: pytest.MonkeyPatch) -> None:
    """One in a million is 4.5e9 units of double precision, more or less, and some eight of single."""
    statement = mf.equations["geometry.ggx.Lambda"]

    class Off:
        exact = staticmethod(statement.exact)

        @staticmethod
        def kernel(*arguments: float) -> np.ndarray:
            return statement.kernel(*arguments) * np.asarray(arguments[0]).dtype.type(1 + 1e-6)

    assert 4e9 < practice._ulps(Off, ["2"], np.float64) < 1e10  # type: ignore[arg-type]
    assert 7 < practice._ulps(Off, ["2"], np.float32) < 19  # type: ignore[arg-type]


def test_albedos_are_the_librarys() -> None:
    found = practice.albedos([0.3, 1.0], [0.0, 60.0])
    assert [row[0] for row in found.rows] == ["0.3", "1"]
    for row, alpha in zip(found.rows, (0.3, 1.0), strict=True):
        expected = mf.Microfacet(mf.Smith(mf.GGX(alpha))).albedo(mf.spherical(np.radians([0.0, 60.0])))
        np.testing.assert_allclose([float(cell) for cell in row[1:]], expected, atol=1e-6)
    assert 0 < found.bound < 1e-6


def test_every_convention_has_its_row() -> None:
    rows = {row[0].strip("`"): row for row in practice.conventions(0.5, 100.0)}
    assert set(rows) == set(CONVENTIONS)
    assert float(rows["squared"][-1]) == 0.25
    assert float(rows["alpha"][-1]) == 0.5
    assert float(rows["pbrt-v4"][-1]) == pytest.approx(0.5**0.5, abs=1e-4)
    assert float(rows["phong"][-1]) == pytest.approx((2 / 102) ** 0.5, abs=1e-4)


def test_forms_of_G2_have_their_extremes() -> None:
    names = np.array([["Smith, height", "V-cavities"]])
    measured = {
        "names": names,
        "albedo": np.array([[[0.5, 0.01], [0.7, 0.01]]]),
        "model_albedo": np.array([[[0.4, 0.6], [0.65, 0.6]]]),
        "distance": np.array([[[[0.1, 0.0], [0.3, 0.0]], [[0.2, 0.0], [0.1, 0.0]]]]),
    }
    found = practice.forms_of_G2(measured)
    assert found["Smith, height"] == pytest.approx((-0.1, -0.05, 0.2))
    assert found["V-cavities"] == pytest.approx((-0.1, 0.1, 0.3))


def test_errors_of_a_picture_are_those_of_the_complete_models() -> None:
    most = np.arange(2 * 3 * 5).reshape(2, 3, 5)
    maps = {"measures": np.array(["albedo", "picture"]), "ggx_most": most, "ggx_complete": np.array([4, 0])}
    np.testing.assert_array_equal(practice.picture_errors(maps, "ggx"), [[19, 15], [24, 20], [29, 25]])
