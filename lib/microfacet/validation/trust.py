"""How many digits of the library are right, and where: every quantity against 50 digits (matt facets: 30), over roughness and
angle.

Views are spaced evenly in the logarithm of the tangent, from 1e-8 above the pole to 1e-8 above the horizon, at one azimuth;
roughnesses from 1e-8 to 1e3. References take directions and roughnesses as the binary numbers they are, of either precision.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import mpmath
import numpy as np
from numpy.typing import NDArray

from microfacet.brdf.diffuse import Diffuse
from microfacet.brdf.specular import Microfacet
from microfacet.geometry import beckmann, ggx
from microfacet.geometry.beckmann import Beckmann
from microfacet.geometry.blinn_phong import NormalizedBlinnPhong
from microfacet.geometry.ggx import GGX
from microfacet.geometry.slopes import Distribution
from microfacet.geometry.ward import Ward
from microfacet.material.fresnel import Conductor, Dielectric, Schlick
from microfacet.statement import DIGITS
from microfacet.visibility import smith
from microfacet.visibility.smith import Smith
from microfacet.visibility.v_cavity import VCavity

Array = NDArray[Any]
Maker = Callable[[float], Distribution]
Exact = Callable[..., mpmath.mpf]

ALPHA = np.logspace(-8, 3, 34)
TANGENT = np.logspace(-8, 8, 41)
AZIMUTH = np.radians(35)
PRECISIONS = (np.float64, np.float32)
MOST: dict[Any, float] = {np.float64: 16.0, np.float32: 7.5}  # digits that a precision can hold
FAMILIES: dict[type, Any] = {GGX: ggx, Beckmann: beckmann}


def directions(real: type, tangent: Array = TANGENT) -> Array:
    """Unit vectors (n, 3) at these tangents of the polar angle, rounded to the precision."""
    sine, cosine = tangent / np.sqrt(1 + tangent**2), 1 / np.sqrt(1 + tangent**2)
    return np.stack([sine * np.cos(AZIMUTH), sine * np.sin(AZIMUTH), cosine], axis=-1).astype(real)


def rounded(alpha: float, real: type) -> float:
    """The roughness that a kernel of this precision sees."""
    return float(real(alpha))


# --- what is compared -------------------------------------------------------------------------------------------------


def digits(value: Array, exact: list[mpmath.mpf], real: type) -> Array:
    """Decimal digits that are right, from 0 to as many as the precision has; NaN where it cannot hold the exact value."""
    found = [_digits(float(v), e, real) for v, e in zip(np.ravel(value), exact, strict=True)]
    return np.reshape(found, np.shape(value))


def _digits(value: float, exact: mpmath.mpf, real: type) -> float:
    limits = np.finfo(real)
    if not float(limits.tiny) < abs(exact) < float(limits.max):
        return np.nan
    if not np.isfinite(value):
        return 0.0
    with mpmath.workdps(DIGITS):
        error = float(abs(mpmath.mpf(value) / exact - 1))
    return float(min(max(-np.log10(error), 0.0), MOST[real])) if error else MOST[real]


def exact_D(ndf: Distribution, m: Any) -> mpmath.mpf:
    """D at a normal of floats or of numbers with more digits."""
    return mpmath.mpf(FAMILIES[type(ndf)].D.exact(*map(_wide, m), *ndf.parameters))


def _wide(number: Any) -> Any:
    return number if isinstance(number, mpmath.mpf) else float(number)


def exact_Lambda(ndf: Distribution, wo: Array) -> mpmath.mpf:
    return mpmath.mpf(FAMILIES[type(ndf)].Lambda.exact(smith.a_o.exact(*map(float, wo), *ndf.parameters)))


def Lambda(ndf: Distribution, wo: Array) -> Array:
    """Smith's Lambda for directions (n, 3), by the kernel that every model calls."""
    return np.asarray(ndf.Lambda(wo))


def D(ndf: Distribution, m: Array) -> Array:
    return np.asarray(ndf.D(m))


QUANTITIES: dict[str, tuple[Callable[[Distribution, Array], Array], Callable[[Distribution, Array], mpmath.mpf]]] = {
    "D": (D, exact_D),
    "Lambda": (Lambda, exact_Lambda),
}


@cache
def exact_map(quantity: str, kind: type, real: type) -> list[list[mpmath.mpf]]:
    """The reference over roughness (rows) and angle, for directions of this precision."""
    exact = QUANTITIES[quantity][1]
    return [[exact(kind(rounded(alpha, real)), w) for w in directions(real)] for alpha in ALPHA]


def map_of(method: Callable[[Distribution, Array], Array], quantity: str, kind: type, real: type) -> Array:
    """Digits of a method (ndf, directions) -> values over roughness (rows) and angle."""
    views = directions(real)
    rows = zip(ALPHA, exact_map(quantity, kind, real), strict=True)
    return np.array([digits(method(kind(rounded(alpha, real)), views), exact, real) for alpha, exact in rows])


# --- samplers: the uniform numbers of which a normal is made ------------------------------------------------------------


def _unstretched(ndf: Distribution, w: Array, power: int) -> list[mpmath.mpf]:
    """A direction (power 1) or a normal (-1) on the surface of unit roughness, of unit length, to 50 digits."""
    scales = [mpmath.mpf(alpha) ** power for alpha in ndf.parameters] + [mpmath.mpf(1)]
    moved = [scale * mpmath.mpf(float(c)) for scale, c in zip(scales, w, strict=True)]
    length = mpmath.sqrt(sum(c * c for c in moved))
    return [c / length for c in moved]


def _ggx_numbers(v: list[mpmath.mpf], h: list[mpmath.mpf]) -> tuple[mpmath.mpf, mpmath.mpf]:
    """Mirrored at the normal, the view falls on a spherical cap: the azimuth there, and the height."""
    twice = 2 * sum(a * b for a, b in zip(v, h, strict=True))
    x, y = (twice * b - a for a, b in zip(v[:2], h[:2], strict=True))
    return mpmath.atan2(y, x) / (2 * mpmath.pi) % 1, 1 - twice * h[2] / (1 + v[2])


def _beckmann_numbers(v: list[mpmath.mpf], h: list[mpmath.mpf]) -> tuple[mpmath.mpf, mpmath.mpf]:
    """The share of what is seen that has a lower slope along the view, and that of lower slopes across it."""
    sine = mpmath.hypot(v[0], v[1])
    x, y = -h[0] / h[2], -h[1] / h[2]
    along, across = (v[0] * x + v[1] * y) / sine, (v[0] * y - v[1] * x) / sine

    def share(q: mpmath.mpf) -> mpmath.mpf:
        return v[2] * mpmath.erfc(-q) / 2 + sine * mpmath.exp(-q * q) / (2 * mpmath.sqrt(mpmath.pi))

    return share(along) / share(v[2] / sine), mpmath.erfc(-across) / 2


def numbers_back(ndf: Distribution, wo: Array, u: Array, m: Array) -> float:
    """Digits of the uniform numbers u that a visible normal gives back; of the second relative to its distance from 0 or 1."""
    if not np.isfinite(m).all():
        return 0.0
    most = MOST[m.dtype.type]
    with mpmath.workdps(DIGITS):
        u1, u2 = (mpmath.mpf(float(one)) for one in u)
        numbers = _ggx_numbers if type(ndf) is GGX else _beckmann_numbers
        first, second = numbers(_unstretched(ndf, wo, 1), _unstretched(ndf, m, -1))
        off = float(max(abs(first - u1), abs(second - u2) / min(u2, 1 - u2)))
    return float(min(max(-np.log10(off), 0), most)) if off else most


# --- the table of the README ------------------------------------------------------------------------------------------

RATIOS = (1.0, 1e-4)  # of alpha_y to alpha_x
FEWER = 4  # every fourth roughness and angle of the maps


def half(wo: Array, wi: Array) -> list[mpmath.mpf]:
    """The unit vector along wo + wi."""
    total = [mpmath.mpf(float(a)) + mpmath.mpf(float(b)) for a, b in zip(wo, wi, strict=True)]
    length = mpmath.sqrt(sum(c * c for c in total))
    return [c / length for c in total]


def exact_rho(ndf: Distribution, wo: Array, wi: Array) -> mpmath.mpf:
    """The BRDF for F = 1, correlated by height."""
    with mpmath.workdps(DIGITS):
        joint = 1 / (1 + exact_Lambda(ndf, wo) + exact_Lambda(ndf, wi))
        return exact_D(ndf, half(wo, wi)) * joint / (4 * mpmath.mpf(float(wo[2])) * mpmath.mpf(float(wi[2])))


def exact_pdf(ndf: Distribution, wo: Array, wi: Array) -> mpmath.mpf:
    """The density of light directions from visible normals."""
    with mpmath.workdps(DIGITS):
        return exact_D(ndf, half(wo, wi)) / (1 + exact_Lambda(ndf, wo)) / (4 * mpmath.mpf(float(wo[2])))


def exact_G1(ndf: Distribution, wo: Array) -> mpmath.mpf:
    with mpmath.workdps(DIGITS):
        return 1 / (1 + exact_Lambda(ndf, wo))


def _normals(ndf: Distribution, real: type) -> Array:
    m = directions(real, TANGENT[::FEWER])
    return digits(D(ndf, m), [exact_D(ndf, one) for one in m], real)


def _masking(ndf: Distribution, real: type) -> Array:
    """At facets that lie flat, which every view sees."""
    views = directions(real, TANGENT[::FEWER])
    up: Array = np.array([0, 0, 1], real)
    return digits(Smith(ndf).G1(views, up), [exact_G1(ndf, wo) for wo in views], real)


def _lobes(ndf: Distribution, real: type) -> Array:
    """BRDF and density, for the mirrored view, for one at right angles to it, and for one that is higher."""
    views, brdf = directions(real, TANGENT[::FEWER]), Microfacet(Smith(ndf))
    turns = [views * np.array([-1, -1, 1], real), views[:, [1, 0, 2]] * np.array([-1, 1, 1], real), np.roll(views, 1, axis=0)]
    found = []
    for lights in turns:
        pairs = list(zip(views, lights, strict=True))
        found.append(digits(brdf.evaluate(views, lights), [exact_rho(ndf, *pair) for pair in pairs], real))
        found.append(digits(brdf.pdf(views, lights), [exact_pdf(ndf, *pair) for pair in pairs], real))
    return np.concatenate(found)


def _drawn(ndf: Distribution, real: type) -> Array:
    views = directions(real, TANGENT[::FEWER])
    numbers: Array = np.array([(0.3, 0.01), (0.6, 0.5), (0.9, 0.99)], real)
    normals = Smith(ndf).sample_visible(views[:, None], numbers)
    return np.array(
        [
            [numbers_back(ndf, wo, *pair) for pair in zip(numbers, row, strict=True)]
            for wo, row in zip(views, normals, strict=True)
        ]
    )


PARTS: dict[str, Callable[[Distribution, type], Array]] = {
    "`D`": _normals,
    "`G1`": _masking,
    "`evaluate`, `pdf`": _lobes,
    "`sample_visible`": _drawn,
}


def fewest(part: Callable[[Distribution, type], Array], kind: Callable[..., Distribution], real: type) -> float:
    """Fewest right digits over all roughnesses, ratios and angles."""
    pairs = [(rounded(alpha, real), rounded(alpha * ratio, real)) for ratio in RATIOS for alpha in ALPHA[::FEWER]]
    return float(min(np.nanmin(part(kind(*pair), real), initial=MOST[real]) for pair in pairs if min(pair) > 0.99 * ALPHA[0]))


def digits_to_trust() -> dict[str, list[float]]:
    """Fewest right digits of each part: GGX in double and single precision, then Beckmann."""
    return {name: [fewest(part, kind, real) for kind in FAMILIES for real in PRECISIONS] for name, part in PARTS.items()}


# --- further models ---------------------------------------------------------------------------------------------------

INDICES = np.logspace(-3, 3, 25)
COSINES = np.append(np.logspace(-8, -0.1, 14), 1.0)
EXPONENTS = np.minimum(2 / ALPHA[::FEWER] ** 2, 1e16)
MATT = np.logspace(-8, 3, 8)  # roughnesses, and
MATT_TANGENT = np.logspace(-8, 8, 9)  # tangents of the lights
CORE = 30  # digits of an integral by quadrature


def _power(n: float, m: Any) -> mpmath.mpf:
    """D of the normalised Blinn-Phong distribution."""
    with mpmath.workdps(DIGITS):
        x, y, z = map(mpmath.mpf, map(_wide, m))
        return (n + mpmath.mpf(2)) / (2 * mpmath.pi) * (z / mpmath.sqrt(x * x + y * y + z * z)) ** n


def _power_normals(real: type) -> Array:
    m = directions(real, TANGENT[::FEWER])
    exponents = [rounded(n, real) for n in EXPONENTS]
    return np.array([digits(NormalizedBlinnPhong(n).D(m), [_power(n, one) for one in m], real) for n in exponents])


def _power_lobe(n: float, wo: Array, wi: Array) -> mpmath.mpf:
    """The BRDF of V-cavities for F = 1."""
    with mpmath.workdps(DIGITS):
        m, (z_o, z_i) = half(wo, wi), (mpmath.mpf(float(w[2])) for w in (wo, wi))
        middle = sum(c * mpmath.mpf(float(a)) for c, a in zip(m, wo, strict=True))
        return _power(n, m) * min(1, 2 * m[2] * min(z_o, z_i) / middle) / (4 * z_o * z_i)


def _power_lobes(real: type) -> Array:
    views, found = directions(real, TANGENT[::FEWER]), []
    for n in (rounded(n, real) for n in EXPONENTS):
        for lights in (views * np.array([-1, -1, 1], real), np.roll(views, 1, axis=0)):
            exact = [_power_lobe(n, *pair) for pair in zip(views, lights, strict=True)]
            found.append(digits(Microfacet(VCavity(NormalizedBlinnPhong(n))).evaluate(views, lights), exact, real))
    return np.array(found)


def _power_drawn(real: type) -> Array:
    """The tangents of drawn normals."""
    u: Array = np.array([(1e-6, 0.1), (0.3, 0.4), (0.99, 0.7)], real)
    found = []
    for n in (rounded(n, real) for n in EXPONENTS):
        m = NormalizedBlinnPhong(n).sample(u).astype(float)
        with mpmath.workdps(DIGITS):
            exact = [mpmath.sqrt((1 - mpmath.mpf(float(one))) ** (-2 / (n + mpmath.mpf(2))) - 1) for one in u[:, 0]]
        found.append(digits(np.hypot(m[:, 0], m[:, 1]) / m[:, 2], exact, real))
    return np.array(found)


def _ward_D(alpha: tuple[float, float], m: Array) -> mpmath.mpf:
    with mpmath.workdps(DIGITS):
        x, y, z, a, b = map(mpmath.mpf, map(float, [*m, *alpha]))
        return mpmath.exp(-((x / a) ** 2 + (y / b) ** 2) / z**2) / (mpmath.pi * a * b)


def _ward_normals(real: type) -> Array:
    m = directions(real, TANGENT[::FEWER])
    pairs = [(rounded(a, real), rounded(a * r, real)) for r in RATIOS for a in ALPHA[::FEWER] if a * r > 0.99 * ALPHA[0]]
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
    found = []
    for eta in (rounded(eta, real) for eta in INDICES if eta != 1):
        for k in (rounded(k, real) for k in absorptions):
            exact = [_amplitudes(float(c), eta, k) for c in cosines]
            found.append(digits((Conductor(eta, k) if k else Dielectric(eta)).F(cosines), exact, real))
    return np.array(found)


def _approximated(real: type) -> Array:
    cosines: Array = COSINES.astype(real)
    found = []
    for F0 in (rounded(F0, real) for F0 in np.logspace(-8, 0, 9)):
        with mpmath.workdps(DIGITS):
            exact = [F0 + (1 - mpmath.mpf(F0)) * (1 - mpmath.mpf(float(c))) ** 5 for c in cosines]
        found.append(digits(Schlick(F0).F(cosines), exact, real))
    return np.array(found)


def exact_matt(ndf: Distribution, wi: Array) -> mpmath.mpf:
    """The BRDF of matt GGX facets seen from above, by one integral over the slope: that over its azimuth has a closed form."""
    with mpmath.workdps(CORE):
        (alpha, _), up = map(mpmath.mpf, ndf.parameters), mpmath.pi
        steep = alpha * mpmath.hypot(*map(float, wi[:2])) / float(wi[2])

        def lit(r: mpmath.mpf) -> mpmath.mpf:
            s = steep * r
            return 2 * up if s <= 1 else 2 * (up - mpmath.acos(1 / s) + mpmath.sqrt(s * s - 1))

        def part(t: mpmath.mpf) -> mpmath.mpf:
            r = mpmath.exp(t)
            return r * r * lit(r) / (up * (1 + r * r) ** 2 * mpmath.sqrt(1 + (alpha * r) ** 2))

        ends = sorted({*map(mpmath.mpf, (-40, -10, 0, 10, 40, 75)), -mpmath.log(steep)})
        whole = mpmath.quad(part, [end for end in ends if -40 <= end <= 75])
        return whole * exact_G1(ndf, wi) / mpmath.pi


def _matt(real: type) -> Array:
    lights, models = directions(real, MATT_TANGENT), [GGX(rounded(alpha, real)) for alpha in MATT]
    up: Array = np.array([0, 0, 1], real)
    exact = [[exact_matt(ndf, wi) for wi in lights] for ndf in models]
    values = [Diffuse(Smith(ndf)).evaluate(up, lights) for ndf in models]
    return np.array([digits(*pair, real) for pair in zip(values, exact, strict=True)])


FURTHER: dict[str, Callable[[type], Array]] = {
    "`NormalizedBlinnPhong.D`": _power_normals,
    "`NormalizedBlinnPhong.sample`": _power_drawn,
    "`evaluate` of it under `VCavity`": _power_lobes,
    "`Ward.D`": _ward_normals,
    "`Dielectric.F`": lambda real: _reflected(real, np.zeros(1)),
    "`Conductor.F`": lambda real: _reflected(real, np.logspace(-3, 3, 5)),
    "`Schlick.F`": _approximated,
    "`Diffuse.evaluate`": _matt,
}


def further_digits() -> dict[str, list[float]]:
    """Fewest right digits of further models, in double and in single precision."""
    return {name: [float(np.nanmin(part(real))) for real in PRECISIONS] for name, part in FURTHER.items()}


def table() -> str:
    """The digits that may be trusted, two tables in Markdown: whole digits, rounded down, at the worst point of the domain."""
    names = [f"{kind.__name__}, {precision}" for kind in FAMILIES for precision in ("double", "single")]
    return "\n\n".join([_table(names, digits_to_trust()), _table(["double", "single"], further_digits())])


def _table(names: list[str], rows: dict[str, list[float]]) -> str:
    lines = [["right digits, at least", *names], [":--", *["--:"] * len(names)]]
    lines += [[name, *(str(int(found)) for found in row)] for name, row in rows.items()]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)
