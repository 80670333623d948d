"""The accuracy table: the fewest correct digits that are found over the whole domain, for each part of the library.

They are sought on a grid, which has the ends of the domain, and at random roughnesses and views. A family of distributions that
states D and Lambda, and one of reflectances that states F, enter the table by themselves.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from itertools import product
from typing import Any

import mpmath
import numpy as np

from microfacet.brdf.diffuse import Diffuse
from microfacet.brdf.microfacet import Microfacet
from microfacet.families import alphas_of, families
from microfacet.geometry.blinn_phong import NormalizedBlinnPhong
from microfacet.geometry.ggx import GGX
from microfacet.geometry.slopes import Distribution
from microfacet.geometry.ward import Ward
from microfacet.material.fresnel import Conductor, Dielectric, Fresnel, Schlick
from microfacet.statements.checks import sample
from microfacet.statements.reference import DIGITS
from microfacet.validation.accuracy import (
    ALPHA,
    NUMBERS,
    PRECISIONS,
    TANGENT,
    Array,
    D,
    _wide,
    digits,
    directions,
    exact_D,
    exact_G1,
    exact_pdf,
    exact_rho,
    half,
    numbers_back,
    rounded,
)
from microfacet.visibility.smith import Smith
from microfacet.visibility.v_cavity import VCavity

RATIOS = (1.0, 1e-4)  # of alpha_y to alpha_x
STRIDE = 4  # every fourth roughness and angle of the maps
RANDOM_CASES, RANDOM_VIEWS = 100, 20  # further roughnesses, and views for each


def _normals(ndf: Distribution, m: Array) -> Array:
    return digits(D(ndf, m), [exact_D(ndf, one) for one in m], m.dtype.type)


def _masking(ndf: Distribution, views: Array) -> Array:
    """At horizontal facets, which face every view."""
    real = views.dtype.type
    up: Array = np.array([0, 0, 1], real)
    return digits(Smith(ndf).G1(views, up), [exact_G1(ndf, wo) for wo in views], real)


def _lobes(ndf: Distribution, views: Array) -> Array:
    """BRDF and density, for the mirrored view, for one at right angles to it, and for another view."""
    real, brdf = views.dtype.type, Microfacet(Smith(ndf))
    all_lights = [
        views * np.array([-1, -1, 1], real),
        views[:, [1, 0, 2]] * np.array([-1, 1, 1], real),
        np.roll(views, 1, axis=0),
    ]
    correct = []
    for lights in all_lights:
        pairs = list(zip(views, lights, strict=True))
        correct.append(digits(brdf.evaluate(views, lights), [exact_rho(ndf, *pair) for pair in pairs], real))
        correct.append(digits(brdf.pdf(views, lights), [exact_pdf(ndf, *pair) for pair in pairs], real))
    return np.concatenate(correct)


def _visible_normals(ndf: Distribution, views: Array) -> Array:
    """Of families whose sampler can be inverted."""
    if type(ndf) not in NUMBERS:
        return np.full(1, np.nan)
    numbers: Array = np.array([(0.3, 0.01), (0.6, 0.5), (0.9, 0.99)], views.dtype)
    normals = Smith(ndf).sample_visible(views[:, None], numbers)
    return np.array(
        [
            [numbers_back(ndf, wo, *pair) for pair in zip(numbers, row, strict=True)]
            for wo, row in zip(views, normals, strict=True)
        ]
    )


PARTS: dict[str, Callable[[Distribution, Array], Array]] = {
    "`D`": _normals,
    "`G1`": _masking,
    "`evaluate`, `pdf`": _lobes,
    "`sample_visible`": _visible_normals,
}


def cases(real: type) -> Iterator[tuple[float, float, Array]]:
    """Two roughnesses and views: those of the maps, then random ones."""
    random = np.random.default_rng(0)
    for alpha_x, ratio in product(ALPHA[::STRIDE], RATIOS):
        if alpha_x * ratio > 0.99 * ALPHA[0]:
            yield rounded(alpha_x, real), rounded(alpha_x * ratio, real), directions(real, TANGENT[::STRIDE])
    for exponent in random.uniform(np.log10(ALPHA[0]), np.log10(ALPHA[-1]), RANDOM_CASES):
        alpha_x, alpha_y = 10**exponent, 10 ** max(exponent + random.uniform(np.log10(RATIOS[-1]), 0), np.log10(ALPHA[0]))
        tangent = 10 ** random.uniform(np.log10(TANGENT[0]), np.log10(TANGENT[-1]), RANDOM_VIEWS)
        yield rounded(alpha_x, real), rounded(alpha_y, real), directions(real, tangent, random.uniform(0, 2 * np.pi))


def fewest(part: Callable[[Distribution, Array], Array], kind: Callable[..., Distribution], real: type) -> float:
    """Fewest right digits over all roughnesses, ratios and angles."""
    correct = np.concatenate([np.ravel(part(kind(alpha_x, alpha_y), views)) for alpha_x, alpha_y, views in cases(real)])
    return float(np.nanmin(correct)) if np.isfinite(correct).any() else np.nan


def stated_families() -> list[type[Distribution]]:
    """Families of two roughnesses that state D and Lambda, and so have a reference of 50 digits: GGX, Beckmann, then others."""
    kinds = families(Distribution, ("GGX", "Beckmann"))
    return [kind for kind in kinds if alphas_of(kind) == 2 and {"D", "Lambda"} <= kind.statements.keys()]


def digits_by_part() -> dict[str, list[float]]:
    """Fewest right digits of each part, for each family in double and in single precision."""
    kinds = stated_families()
    return {name: [fewest(part, kind, real) for kind in kinds for real in PRECISIONS] for name, part in PARTS.items()}


# --- further models ---------------------------------------------------------------------------------------------------

INDICES = np.logspace(-3, 3, 25)
COSINES = np.append(np.logspace(-8, -0.1, 14), 1.0)
EXPONENTS = np.minimum(2 / ALPHA[::STRIDE] ** 2, 1e16)
MATT = np.logspace(-8, 3, 8)  # roughnesses, and
MATT_TANGENT = np.logspace(-8, 8, 9)  # tangents of the lights
CORE = 30  # digits of an integral by quadrature


def _power(n: float, m: Any) -> mpmath.mpf:
    """D of the normalised Blinn-Phong distribution."""
    with mpmath.workdps(DIGITS):
        x, y, z = map(mpmath.mpf, map(_wide, m))
        return (n + mpmath.mpf(2)) / (2 * mpmath.pi) * (z / mpmath.sqrt(x * x + y * y + z * z)) ** n


def _power_normals(real: type) -> Array:
    m = directions(real, TANGENT[::STRIDE])
    exponents = [rounded(n, real) for n in EXPONENTS]
    return np.array([digits(NormalizedBlinnPhong(n).D(m), [_power(n, one) for one in m], real) for n in exponents])


def _power_lobe(n: float, wo: Array, wi: Array) -> mpmath.mpf:
    """The BRDF of V-cavities for F = 1."""
    with mpmath.workdps(DIGITS):
        m, (z_o, z_i) = half(wo, wi), (mpmath.mpf(float(w[2])) for w in (wo, wi))
        middle = sum(c * mpmath.mpf(float(a)) for c, a in zip(m, wo, strict=True))
        return _power(n, m) * min(1, 2 * m[2] * min(z_o, z_i) / middle) / (4 * z_o * z_i)


def _power_lobes(real: type) -> Array:
    views, correct = directions(real, TANGENT[::STRIDE]), []
    for n in (rounded(n, real) for n in EXPONENTS):
        for lights in (views * np.array([-1, -1, 1], real), np.roll(views, 1, axis=0)):
            exact = [_power_lobe(n, *pair) for pair in zip(views, lights, strict=True)]
            correct.append(digits(Microfacet(VCavity(NormalizedBlinnPhong(n))).evaluate(views, lights), exact, real))
    return np.array(correct)


def _power_sampled(real: type) -> Array:
    """The tangents of sampled normals."""
    u: Array = np.array([(1e-6, 0.1), (0.3, 0.4), (0.99, 0.7)], real)
    correct = []
    for n in (rounded(n, real) for n in EXPONENTS):
        m = NormalizedBlinnPhong(n).sample(u).astype(float)
        with mpmath.workdps(DIGITS):
            exact = [mpmath.sqrt((1 - mpmath.mpf(float(one))) ** (-2 / (n + mpmath.mpf(2))) - 1) for one in u[:, 0]]
        correct.append(digits(np.hypot(m[:, 0], m[:, 1]) / m[:, 2], exact, real))
    return np.array(correct)


def _ward_D(alpha: tuple[float, float], m: Array) -> mpmath.mpf:
    with mpmath.workdps(DIGITS):
        x, y, z, a, b = map(mpmath.mpf, map(float, [*m, *alpha]))
        return mpmath.exp(-((x / a) ** 2 + (y / b) ** 2) / z**2) / (mpmath.pi * a * b)


def _ward_normals(real: type) -> Array:
    m = directions(real, TANGENT[::STRIDE])
    pairs = [(rounded(a, real), rounded(a * r, real)) for r in RATIOS for a in ALPHA[::STRIDE] if a * r > 0.99 * ALPHA[0]]
    return np.array([digits(Ward(*pair).D(m), [_ward_D(pair, one) for one in m], real) for pair in pairs])


def _amplitudes(c: float, eta: float, k: float) -> mpmath.mpf:
    """The mean of the squared amplitudes of both polarisations, from Snell's law."""
    with mpmath.workdps(DIGITS):
        index, c = mpmath.mpc(eta, k), mpmath.mpf(c)
        root = mpmath.sqrt(index**2 - 1 + c * c)
        across, along = (c - root) / (c + root), (index**2 * c - root) / (index**2 * c + root)
        return (abs(across) ** 2 + abs(along) ** 2) / 2


def _reflected(real: type, absorptions: Array) -> Array:
    cosines: Array = COSINES.astype(real)
    correct = []
    for eta in (rounded(eta, real) for eta in INDICES if eta != 1):
        for k in (rounded(k, real) for k in absorptions):
            exact = [_amplitudes(float(c), eta, k) for c in cosines]
            correct.append(digits((Conductor(eta, k) if k else Dielectric(eta)).F(cosines), exact, real))
    return np.array(correct)


def _approximated(real: type) -> Array:
    cosines: Array = COSINES.astype(real)
    correct = []
    for F0 in (rounded(F0, real) for F0 in np.logspace(-8, 0, 9)):
        with mpmath.workdps(DIGITS):
            exact = [F0 + (1 - mpmath.mpf(F0)) * (1 - mpmath.mpf(float(c))) ** 5 for c in cosines]
        correct.append(digits(Schlick(F0).F(cosines), exact, real))
    return np.array(correct)


def _stated_F(kind: type[Fresnel], real: type) -> Array:
    """Over the domain of the statement."""
    statement = kind.statements["F"]
    points = sample(statement, real)
    make: Any = kind
    return digits(make(*points.T[1:]).F(points[:, 0]), [statement.exact(*point) for point in points], real)


def exact_matt(ndf: Distribution, wi: Array) -> mpmath.mpf:
    """The BRDF of matt GGX facets seen from above, by one integral over the slope: that over its azimuth has a closed form."""
    with mpmath.workdps(CORE):
        (alpha, _), up = map(mpmath.mpf, ndf.parameters), mpmath.pi
        steep = alpha * mpmath.hypot(*map(float, wi[:2])) / float(wi[2])

        def illuminated_azimuths(r: mpmath.mpf) -> mpmath.mpf:
            s = steep * r
            return 2 * up if s <= 1 else 2 * (up - mpmath.acos(1 / s) + mpmath.sqrt(s * s - 1))

        def part(t: mpmath.mpf) -> mpmath.mpf:
            r = mpmath.exp(t)
            return r * r * illuminated_azimuths(r) / (up * (1 + r * r) ** 2 * mpmath.sqrt(1 + (alpha * r) ** 2))

        ends = sorted({*map(mpmath.mpf, (-40, -10, 0, 10, 40, 75)), -mpmath.log(steep)})
        integral = mpmath.quad(part, [end for end in ends if -40 <= end <= 75])
        return integral * exact_G1(ndf, wi) / mpmath.pi


def _matt(real: type) -> Array:
    lights, models = directions(real, MATT_TANGENT), [GGX(rounded(alpha, real)) for alpha in MATT]
    up: Array = np.array([0, 0, 1], real)
    exact = [[exact_matt(ndf, wi) for wi in lights] for ndf in models]
    values = [Diffuse(Smith(ndf)).evaluate(up, lights) for ndf in models]
    return np.array([digits(*pair, real) for pair in zip(values, exact, strict=True)])


FURTHER: dict[str, Callable[[type], Array]] = {
    "`NormalizedBlinnPhong.D`": _power_normals,
    "`NormalizedBlinnPhong.sample`": _power_sampled,
    "`evaluate` of it under `VCavity`": _power_lobes,
    "`Ward.D`": _ward_normals,
    "`Dielectric.F`": lambda real: _reflected(real, np.zeros(1)),
    "`Conductor.F`": lambda real: _reflected(real, np.logspace(-3, 3, 5)),
    "`Schlick.F`": _approximated,
    "`Diffuse.evaluate`": _matt,
}


def further_parts() -> dict[str, Callable[[type], Array]]:
    """The parts above, and each family of reflectances that states F and is not among them."""
    stated = {f"`{kind.__name__}.F`": partial(_stated_F, kind) for kind in families(Fresnel) if "F" in kind.statements}
    return FURTHER | {name: part for name, part in stated.items() if name not in FURTHER}


def further_digits() -> dict[str, list[float]]:
    """Fewest right digits of further models, in double and in single precision."""
    return {name: [float(np.nanmin(part(real))) for real in PRECISIONS] for name, part in further_parts().items()}


def table() -> str:
    """The fewest correct digits, two tables in Markdown: whole digits, rounded down, at the worst point of the domain."""
    names = [f"{kind.__name__}, {precision}" for kind in stated_families() for precision in ("double", "single")]
    return "\n\n".join([_table(names, digits_by_part()), _table(["double", "single"], further_digits())])


def _table(names: list[str], rows: dict[str, list[float]]) -> str:
    lines = [["right digits", *names], [":--", *["--:"] * len(names)]]
    lines += [[name, *("–" if np.isnan(correct) else str(int(correct)) for correct in row)] for name, row in rows.items()]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)
