"""For each quantity the ways to have it: what is timed, how far off each is, and the text that was timed.

A `Method` computes the same thing as the others of its quantity: `prepare(size)` gives a call without arguments, and
`error()` its largest relative error over a fixed set of arguments, by a reference of higher precision. Sizes are numbers of
values, or of nodes along one side of a rule.
"""

from __future__ import annotations

import hashlib
import inspect
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import microfacet as mf
import mpmath
import numpy as np
from microfacet import kernels
from microfacet.directions import spherical
from microfacet.kernels import Batch
from microfacet.validation.equations import residuals
from scipy import integrate, special, stats

ALPHA = (0.3, 0.5)
LONG = np.longdouble
BLOCK = 16384  # values that NumPy takes at once when blocked: its arrays stay in the cache


@dataclass(frozen=True)
class Method:
    """prepare: from a size to a call; error: from a size to an error; sizes: tried, the last is the one charted for arrays;
    code: functions and batches whose texts are timed; each: whether the time is one per value."""

    words: str
    prepare: Callable[[int], Callable[[], Any]]
    error: Callable[[int], float]
    sizes: tuple[int, ...]
    code: tuple[Any, ...]
    each: bool = True

    @property
    def fingerprint(self) -> str:
        """Changes when the code that is timed does."""
        return hashlib.sha256("\n".join(map(_text, self.code)).encode()).hexdigest()[:16]


def _text(thing: Any) -> str:
    if isinstance(thing, Batch):
        return thing.text(np.float64) + inspect.getsource(Batch) + inspect.getsource(kernels._share)
    return inspect.getsource(thing)


def worst(values: Any, exact: Any) -> float:
    """Largest relative error."""
    return float(np.max(np.abs(np.asarray(values, LONG) / np.asarray(exact, LONG) - 1)))


def directions(count: int, seed: int, real: type = np.float64) -> np.ndarray:
    """Directions of the upper hemisphere, uniform in solid angle, none within a thousandth of the horizon."""
    u = np.random.default_rng(seed).random((2, count))
    return spherical(np.arccos(0.001 + 0.999 * u[0]), 2 * np.pi * u[1]).astype(real)


# --- Lambda of Beckmann ----------------------------------------------------------------------------------------------

LAMBDA = mf.equations["visibility.beckmann.Lambda"]
A = np.geomspace(0.01, 5, 400)
LAMBDA_SIZES = (10**6,)


def lambda_erfc(a: np.ndarray) -> np.ndarray:
    return -0.5 * special.erfc(a) + np.exp(-a * a) / (2 * np.sqrt(np.pi) * a)


def lambda_erfcx(a: np.ndarray) -> np.ndarray:
    return np.exp(-a * a) * (1 / (2 * np.sqrt(np.pi) * a) - 0.5 * special.erfcx(a))


def lambda_walter(a: np.ndarray) -> np.ndarray:
    return np.where(a < 1.6, (1 - 1.259 * a + 0.396 * a * a) / (3.535 * a + 2.181 * a * a), 0.0)


def lambda_library(a: np.ndarray) -> np.ndarray:
    return np.asarray(LAMBDA.kernel(a))


def _masking_error(method: Callable[..., Any], real: type) -> float:
    """Of G1 = 1/(1 + Lambda), which is what a renderer uses."""
    a = A.astype(real)
    exact = np.array([float(LAMBDA.exact(float(v))) for v in a], LONG)
    return worst(1 / (1 + np.asarray(method(a), LONG)), 1 / (1 + exact))


def _lambda(words: str, method: Callable[..., Any], real: type, code: tuple[Any, ...]) -> Method:
    def prepare(size: int) -> Callable[[], Any]:
        a = np.geomspace(0.01, 5, size).astype(real)
        return lambda: method(a)

    return Method(words, prepare, lambda size: _masking_error(method, real), LAMBDA_SIZES, code)


LAMBDAS = {
    "erfc": _lambda("SciPy's erfc, double", lambda_erfc, np.float64, (lambda_erfc,)),
    "erfc_single": _lambda("SciPy's erfc, single", lambda_erfc, np.float32, (lambda_erfc,)),
    "erfcx": _lambda("SciPy's erfcx, double", lambda_erfcx, np.float64, (lambda_erfcx,)),
    "walter": _lambda("Walter's fit, double", lambda_walter, np.float64, (lambda_walter,)),
    "library": _lambda("this library, double", lambda_library, np.float64, (LAMBDA._batch,)),
    "library_single": _lambda("this library, single", lambda_library, np.float32, (LAMBDA._batch,)),
}

# --- the BRDF of GGX -------------------------------------------------------------------------------------------------

BRDF = mf.Microfacet(mf.Smith(mf.GGX(*ALPHA)))
BRDF_SIZES = (100, 1000, 10**4, 10**5, 10**6, 4 * 10**6)


def brdf_numpy(wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
    """As the papers print it, in whole arrays."""
    ax, ay = (wo.dtype.type(value) for value in ALPHA)
    half = wo + wi
    half = half / np.linalg.norm(half, axis=-1, keepdims=True)
    D = 1 / (wo.dtype.type(np.pi) * ax * ay * ((half[:, 0] / ax) ** 2 + (half[:, 1] / ay) ** 2 + half[:, 2] ** 2) ** 2)
    views = [(np.sqrt(1 + ((ax * w[:, 0]) ** 2 + (ay * w[:, 1]) ** 2) / w[:, 2] ** 2) - 1) / 2 for w in (wo, wi)]
    return np.asarray(D / (1 + views[0] + views[1]) / (4 * wo[:, 2] * wi[:, 2]))


def brdf_blocked(wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
    out = np.empty(len(wo), wo.dtype)
    for k in range(0, len(wo), BLOCK):
        out[k : k + BLOCK] = brdf_numpy(wo[k : k + BLOCK], wi[k : k + BLOCK])
    return out


def brdf_library(wo: np.ndarray, wi: np.ndarray) -> np.ndarray:
    return np.asarray(BRDF.evaluate(wo, wi))


def _brdf(words: str, method: Callable[..., Any], real: type, code: tuple[Any, ...]) -> Method:
    def prepare(size: int) -> Callable[[], Any]:
        wo, wi = directions(size, 1, real), directions(size, 2, real)
        return lambda: method(wo, wi)

    def error(size: int) -> float:
        wo, wi = directions(2000, 3, real), directions(2000, 4, real)
        return worst(method(wo, wi), brdf_numpy(wo.astype(LONG), wi.astype(LONG)))

    return Method(words, prepare, error, BRDF_SIZES, code)


BRDFS = {
    "plain": _brdf("NumPy, double", brdf_numpy, np.float64, (brdf_numpy,)),
    "plain_single": _brdf("NumPy, single", brdf_numpy, np.float32, (brdf_numpy,)),
    "blocked": _brdf("NumPy blocked, double", brdf_blocked, np.float64, (brdf_numpy, brdf_blocked)),
    "blocked_single": _brdf("NumPy blocked, single", brdf_blocked, np.float32, (brdf_numpy, brdf_blocked)),
    "library": _brdf("this library, double", brdf_library, np.float64, (BRDF._evaluation,)),
    "library_single": _brdf("this library, single", brdf_library, np.float32, (BRDF._evaluation,)),
}

# --- the visible area of a Beckmann surface --------------------------------------------------------------------------

ROUGH, VIEW = 0.1, np.radians(75)
COS, SIN = np.cos(VIEW), np.sin(VIEW)
SMOOTH = mf.Smith(mf.Beckmann(ROUGH))


def area_exact() -> Any:
    """cos theta (1 + Lambda), the projected area of the facets turned to the viewer."""
    mu, across = mpmath.mpf(float(COS)), mpmath.mpf(float(SIN))
    a = mu / (mpmath.mpf(ROUGH) * across)
    tail = mpmath.exp(-a * a) / (2 * a * mpmath.sqrt(mpmath.pi)) - mpmath.erfc(a) / 2
    return mu * (1 + tail)


def slopes_density(x: Any, y: Any) -> Any:
    return np.exp(-(x * x + y * y) / ROUGH**2) / (np.pi * ROUGH**2)


def on_sphere(theta: Any, phi: Any) -> Any:
    """What is summed over angles: <wo, wm> D(wm) sin theta."""
    z = np.cos(theta)
    density = np.exp(-(np.tan(theta) ** 2) / ROUGH**2) / (np.pi * ROUGH**2 * z**4)
    return np.maximum(SIN * np.sin(theta) * np.cos(phi) + COS * z, 0) * density * np.sin(theta)


def midpoint(n: int) -> float:
    theta, phi = (np.arange(n) + 0.5) * np.pi / 2 / n, (np.arange(n) + 0.5) * 2 * np.pi / n
    return float(np.sum(on_sphere(theta[:, None], phi)) * (np.pi / 2 / n) * (2 * np.pi / n))


legendre = cache(np.polynomial.legendre.leggauss)  # nodes are tabulated, and cost nothing when used again


def gauss_angles(n: int) -> float:
    x, w = legendre(n)
    return float(np.einsum("i,j,ij", w, w, on_sphere((x[:, None] + 1) * np.pi / 4, (x + 1) * np.pi)) * np.pi**2 / 4)


def in_slopes(n: int, x: np.ndarray, w: np.ndarray) -> float:
    """Nodes on (-1, 1): slopes along the view end at its edge, tangents take them to the tails."""
    edge = np.arctan(COS / SIN / ROUGH)
    along = edge + (x - 1) * (edge + np.pi / 2) / 2
    q, dq = ROUGH * np.tan(along), w * (edge + np.pi / 2) / 2 * ROUGH / np.cos(along) ** 2
    r, dr = ROUGH * np.tan(x * np.pi / 2), w * np.pi / 2 * ROUGH / np.cos(x * np.pi / 2) ** 2
    return float(np.einsum("i,j,ij", dq * (COS - SIN * q), dr, slopes_density(q[:, None], r)))


def gauss_slopes(n: int) -> float:
    return in_slopes(n, *legendre(n))


def tanh_sinh(n: int) -> float:
    t = np.linspace(-2.8, 2.8, n)
    x = np.tanh(np.pi / 2 * np.sinh(t))
    w = np.pi / 2 * np.cosh(t) / np.cosh(np.pi / 2 * np.sinh(t)) ** 2 * (t[1] - t[0])
    return in_slopes(n, x, w)


def cubature(digits: int) -> float:
    """SciPy's adaptive cubature, in tangents of slopes."""
    edge = np.arctan(COS / SIN / ROUGH)

    def integrand(points: np.ndarray) -> np.ndarray:
        q, r = ROUGH * np.tan(points[:, 0]), ROUGH * np.tan(points[:, 1])
        stretch = ROUGH**2 / np.cos(points[:, 0]) ** 2 / np.cos(points[:, 1]) ** 2
        return np.asarray((COS - SIN * q) * slopes_density(q, r) * stretch)

    low, high = [-np.pi / 2, -np.pi / 2], [edge, np.pi / 2]
    return float(integrate.cubature(integrand, low, high, rule="gk21", rtol=10.0**-digits, atol=0).estimate)


def monte_carlo(n: int, points: np.ndarray | None = None) -> float:
    """Facets by their slopes, drawn as D has them; each counts by what it shows."""
    u = np.random.default_rng(0).random((n * n, 2)) if points is None else points
    q = ROUGH * np.sqrt(-np.log1p(-u[:, 0])) * np.cos(2 * np.pi * u[:, 1])
    return float(np.mean(np.maximum(COS - SIN * q, 0)))


def sobol(n: int) -> float:
    points = stats.qmc.Sobol(2, seed=0).random_base2(round(2 * np.log2(n)))
    return monte_carlo(n, points)


def library(n: int) -> float:
    """The library's rule with its own error estimate: not this area alone, but all four validation equations."""
    found = residuals(SMOOTH, spherical(np.array([VIEW])))["visible_area"][0][0]
    return float((1 + found) * area_exact())


def _area(words: str, method: Callable[[int], float], sizes: Sequence[int], code: tuple[Any, ...]) -> Method:
    return Method(
        words,
        lambda size: lambda: method(size),
        lambda size: float(abs(method(size) / area_exact() - 1)),
        tuple(sizes),
        code,
        each=False,
    )


NODES = (8, 16, 32, 64, 128, 256)
AREAS = {
    "midpoint": _area("midpoints on the sphere", midpoint, (*NODES, 512, 1024), (midpoint, on_sphere)),
    "gauss_angles": _area("Gauss-Legendre, angles", gauss_angles, (*NODES, 512), (gauss_angles, on_sphere)),
    "gauss_slopes": _area("Gauss-Legendre, slopes", gauss_slopes, NODES[:-1], (gauss_slopes, in_slopes)),
    "tanh_sinh": _area("tanh-sinh, slopes", tanh_sinh, NODES, (tanh_sinh, in_slopes)),
    "cubature": _area("SciPy's cubature, slopes", cubature, (2, 4, 8, 12), (cubature,)),
    "monte_carlo": _area("Monte Carlo", monte_carlo, (*NODES, 512), (monte_carlo,)),
    "sobol": _area("Sobol", sobol, (*NODES, 512), (sobol, monte_carlo)),
    "library": _area("this library (all four)", library, (0,), (residuals,)),
}

# --- sampling visible normals ----------------------------------------------------------------------------------------

SAMPLED = mf.Smith(mf.GGX(*ALPHA))
GAUSSIAN = mf.Smith(mf.Beckmann(*ALPHA))
SAMPLE_SIZES = (10**6,)


def caps_numpy(wo: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Spherical caps in whole arrays."""
    scale = np.array([*ALPHA, 1], wo.dtype)
    v = wo * scale
    v = v / np.sqrt(np.sum(v * v, -1))[:, None]
    above = (1 - u[:, 1]) * (1 + v[:, 2])
    radius = np.sqrt((above + (v[:, 0] ** 2 + v[:, 1] ** 2) / (1 + v[:, 2])) * u[:, 1] * (1 + v[:, 2]))
    turn = 2 * wo.dtype.type(_PI) * u[:, 0]
    m = np.stack([radius * np.cos(turn) + v[:, 0], radius * np.sin(turn) + v[:, 1], above], -1) * scale
    return np.asarray(m / np.sqrt(np.sum(m * m, -1))[:, None])


_PI = LONG("3.14159265358979323846264338327950288")


def library_samples(wo: np.ndarray, u: np.ndarray) -> np.ndarray:
    return np.asarray(SAMPLED.sample_visible(wo, u))


def gaussian_samples(wo: np.ndarray, u: np.ndarray) -> np.ndarray:
    return np.asarray(GAUSSIAN.sample_visible(wo, u))


def _gaussian_error(real: type) -> float:
    """How far the visible share of slopes below the one drawn is from the number it was drawn with; seen along x."""
    theta = np.radians(np.repeat([10.0, 45.0, 80.0, 89.0], 100)).astype(real)
    u = np.stack([np.random.default_rng(5).uniform(0.001, 0.999, 400), np.full(400, 0.5)], -1).astype(real)
    wo = spherical(theta).astype(real)
    m = np.asarray(gaussian_samples(wo, u), np.float64)
    q, a = -m[:, 0] / m[:, 2] / ALPHA[0], wo[:, 2].astype(float) / (ALPHA[0] * wo[:, 0].astype(float))

    def share(x: np.ndarray) -> np.ndarray:
        return np.asarray(0.5 * a * special.erfc(-x) + 0.5 * np.exp(-x * x) / np.sqrt(np.pi))

    return float(np.max(np.abs(share(q) / share(a) - u[:, 0].astype(float))))


def _caps_error(method: Callable[..., Any], real: type) -> float:
    """Largest distance of a normal from where the same numbers send it in extended precision."""
    wo, u = directions(4000, 7, real), np.random.default_rng(8).random((4000, 2)).astype(real)
    u = np.minimum(u, np.nextafter(real(1), real(0)))
    exact = caps_numpy(wo.astype(LONG), u.astype(LONG))
    return float(np.max(np.sqrt(np.sum((np.asarray(method(wo, u), LONG) - exact) ** 2, -1))))


def _samples(words: str, method: Callable[..., Any], real: type, error: Callable[[], float], code: tuple[Any, ...]) -> Method:
    def prepare(size: int) -> Callable[[], Any]:
        wo = directions(size, 5, real)
        u = np.minimum(np.random.default_rng(6).random((size, 2)).astype(real), np.nextafter(real(1), real(0)))
        return lambda: method(wo, u)

    return Method(words, prepare, lambda size: error(), SAMPLE_SIZES, code)


def _loop_of(model: Any) -> Batch:
    from microfacet.visibility.masking import _sampling

    return _sampling(model.sampler)


SAMPLES = {
    "plain": _samples("GGX, NumPy, double", caps_numpy, np.float64, lambda: _caps_error(caps_numpy, np.float64), (caps_numpy,)),
    "library": _samples(
        "GGX, this library, double",
        library_samples,
        np.float64,
        lambda: _caps_error(library_samples, np.float64),
        (_loop_of(SAMPLED),),
    ),
    "library_single": _samples(
        "GGX, this library, single",
        library_samples,
        np.float32,
        lambda: _caps_error(library_samples, np.float32),
        (_loop_of(SAMPLED),),
    ),
    "beckmann": _samples(
        "Beckmann, this library, double",
        gaussian_samples,
        np.float64,
        lambda: _gaussian_error(np.float64),
        (_loop_of(GAUSSIAN),),
    ),
    "beckmann_single": _samples(
        "Beckmann, this library, single",
        gaussian_samples,
        np.float32,
        lambda: _gaussian_error(np.float32),
        (_loop_of(GAUSSIAN),),
    ),
}

# --- Fresnel reflectance ---------------------------------------------------------------------------------------------

GLASS = 1.5
EXACT, FITTED = mf.Dielectric(GLASS), mf.Schlick(((GLASS - 1) / (GLASS + 1)) ** 2)
FRESNEL_SIZES = (10**6,)


def fresnel_numpy(c: np.ndarray) -> np.ndarray:
    g = np.sqrt(c.dtype.type(GLASS) ** 2 - 1 + c * c)
    return np.asarray(((g - c) / (g + c)) ** 2 * (1 + ((c * (g + c) - 1) / (c * (g - c) + 1)) ** 2) / 2)


def fresnel_exact(c: np.ndarray) -> np.ndarray:
    return np.asarray(EXACT.F(c))


def fresnel_schlick(c: np.ndarray) -> np.ndarray:
    return np.asarray(FITTED.F(c))


def _fresnel(words: str, method: Callable[..., Any], real: type, code: tuple[Any, ...]) -> Method:
    def prepare(size: int) -> Callable[[], Any]:
        c = np.linspace(0, 1, size).astype(real)
        return lambda: method(c)

    def error(size: int) -> float:
        c = np.linspace(0, 1, 5001).astype(real)
        return worst(method(c), fresnel_numpy(c.astype(LONG)))

    return Method(words, prepare, error, FRESNEL_SIZES, code)


def _loop_of_fresnel(kind: type) -> Batch:
    from microfacet.material.fresnel import _over_cosines

    return _over_cosines(kind.kernel)  # type: ignore[attr-defined]


FRESNELS = {
    "plain": _fresnel("exact, NumPy, double", fresnel_numpy, np.float64, (fresnel_numpy,)),
    "library": _fresnel("exact, this library, double", fresnel_exact, np.float64, (_loop_of_fresnel(mf.Dielectric),)),
    "library_single": _fresnel("exact, this library, single", fresnel_exact, np.float32, (_loop_of_fresnel(mf.Dielectric),)),
    "schlick": _fresnel("Schlick, this library, double", fresnel_schlick, np.float64, (_loop_of_fresnel(mf.Schlick),)),
    "schlick_single": _fresnel("Schlick, this library, single", fresnel_schlick, np.float32, (_loop_of_fresnel(mf.Schlick),)),
}

QUANTITIES: dict[str, dict[str, Method]] = {
    "masking": LAMBDAS,
    "brdf": BRDFS,
    "integral": AREAS,
    "sampling": SAMPLES,
    "fresnel": FRESNELS,
}
