"""Ways to integrate the visible area of a Beckmann surface."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import microfacet as mf
import mpmath
import numpy as np
from microfacet.directions import spherical
from microfacet.statements import ball_functions, balls
from microfacet.validation import adaptive, equations
from microfacet.validation.adaptive import seen_area
from microfacet.validation.equations import residual
from microfacet.visibility import quadrature
from scipy import integrate, special, stats

from benchmarks.method import Method

ROUGH, VIEW = 0.1, np.radians(75)
COS, SIN = np.cos(VIEW), np.sin(VIEW)
SEEN_FROM = spherical(np.array([VIEW]))
SMOOTH = mf.Smith(mf.Beckmann(ROUGH))


@cache
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


def gauss_cdf(n: int) -> float:
    """Nodes in the distribution function of slopes, which takes the density away and leaves what a facet shows."""
    x, w = legendre(n)
    last = special.ndtr(np.sqrt(2) * COS / SIN / ROUGH)
    q = ROUGH * special.erfinv(last * (x + 1) - 1)
    return float(np.einsum("i,j->", w * (COS - SIN * q), w) * last / 4)


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


def library() -> tuple[np.ndarray, np.ndarray]:
    """The library's rule: by how much the area is off once Smith's masking is on it, and the rule's own error estimate."""
    return residual(SMOOTH, "visible_area", SEEN_FROM)


def density(wm: np.ndarray) -> np.ndarray:
    """D as anybody might hand it over: a function of normals, of which nothing else is known."""
    return np.asarray(np.exp((1 - 1 / wm[:, 2] ** 2) / ROUGH**2) / (np.pi * ROUGH**2 * wm[:, 2] ** 4))


def any_function(digits: int) -> float:
    """The library's adaptive rule."""
    return COS * seen_area(density, spherical(VIEW), tolerance=10.0**-digits).value


def enclosed(digits: int) -> Any:
    """Arb: a ball that is proved to hold the area, over slopes along the view in units of alpha; those across are done."""
    with balls.precision(int(3.33 * digits) + 24):
        reach, along = balls.ball(np.ceil(np.sqrt(2.31 * digits + 3))), balls.ball(SIN) * balls.ball(ROUGH)
        root = balls.pi().sqrt()
        tail = balls.ball(COS) * reach.erfc() / 2 + along * (-reach * reach).exp() / (2 * root)
        edge = (balls.ball(COS) / along).min(reach)
        seen = ball_functions.integral(lambda w, _: (COS - along * w) * (-w * w).exp() / root, -reach, edge, digits)
        return seen + tail.union(-tail)


def _width(digits: int) -> float:
    """Relative radius of the ball, which bounds its error."""
    found = enclosed(digits)
    return float(found.rad()) / float(found.mid())


def _area(label: str, method: Callable[[int], float], sizes: Sequence[int], code: tuple[Any, ...]) -> Method:
    return Method(
        label,
        lambda size: lambda: method(size),
        lambda size: float(abs(method(size) / area_exact() - 1)),
        tuple(sizes),
        code,
        each=False,
    )


NODES = (8, 16, 32, 64, 128, 256)
METHODS = {
    "midpoint": _area("midpoints on the sphere", midpoint, (*NODES, 512, 1024), (midpoint, on_sphere)),
    "gauss_angles": _area("Gauss-Legendre, angles", gauss_angles, (*NODES, 512), (gauss_angles, on_sphere)),
    "gauss_slopes": _area("Gauss-Legendre, slopes", gauss_slopes, NODES[:-1], (gauss_slopes, in_slopes)),
    "gauss_cdf": _area("Gauss-Legendre, slopes' CDF", gauss_cdf, (*NODES, 512), (gauss_cdf,)),
    "tanh_sinh": _area("tanh-sinh, slopes", tanh_sinh, NODES, (tanh_sinh, in_slopes)),
    "cubature": _area("SciPy's cubature, slopes", cubature, (2, 4, 8, 12), (cubature,)),
    "monte_carlo": _area("Monte Carlo", monte_carlo, (*NODES, 512), (monte_carlo,)),
    "sobol": _area("Sobol", sobol, (*NODES, 512), (sobol, monte_carlo)),
    "arb": Method(
        "Arb, proved", lambda digits: lambda: enclosed(digits), _width, (3, 6, 9, 12, 15), (enclosed, balls), each=False
    ),
    "any": _area("this library, any function", any_function, (12,), (any_function, density, adaptive)),
    "library": Method(
        "this library",
        lambda size: library,
        lambda size: float(abs(library()[0][0])),
        (0,),
        (library, equations, quadrature),
        each=False,
    ),
}
