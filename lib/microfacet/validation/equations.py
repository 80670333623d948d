"""Is a model a microfacet model? The four validation equations of the talk, and the three classic ones."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from math import sqrt
from typing import Any

import numpy as np

from microfacet.arithmetic import two_sum
from microfacet.brdf.specular import Microfacet
from microfacet.directions import as_vectors, one_of, positive, spherical
from microfacet.geometry.slopes import Distribution
from microfacet.material.reflection import reflected
from microfacet.visibility.masking import Masking, visible_density
from microfacet.visibility.quadrature import seen_batch

TOLERANCE = 1e-9  # what a relative residual may be and still count as rounding and quadrature
ROUNDING = 1e-13  # of a sum of some 10^4 terms
UNIT = 1e-6  # how far a unit vector's length may be from 1: a single-precision one's is

THETA = np.radians([0, 15, 30, 45, 60, 75, 85, 89])
PHI = np.radians([0, 35, 90])

TITLES = {
    "projected_area": "visible from above: facets project to the whole surface",
    "visible_area": "visible facets project to the area that the viewer sees",
    "visible_norm": "visible normals are a distribution",
    "weak_furnace": "without shadowing, mirror facets lose nothing",
    "positivity": "the BRDF is nowhere negative",
    "reciprocity": "light and viewer may change places",
    "energy": "no more light leaves than arrives",
}


@dataclass(frozen=True)
class Verdict:
    """What one equation says of a model.

    verdict: "holds", "fails", or "undecided" where the error bound is too large to tell. residual: the worst relative
    deviation from the equation. bound: its error, estimated from two quadrature rules and rounding, not proved.
    where: the direction, or pair, in degrees, at which the residual was found.
    """

    equation: str
    verdict: str
    residual: float
    bound: float
    where: str

    @property
    def title(self) -> str:
        return TITLES[self.equation]


class Validation(Mapping[str, Verdict]):
    """The verdicts on one model, by the name of the equation."""

    def __init__(self, model: str, verdicts: list[Verdict]) -> None:
        self.model, self._verdicts = model, {v.equation: v for v in verdicts}

    def __getitem__(self, equation: str) -> Verdict:
        return self._verdicts[equation]

    def __iter__(self) -> Iterator[str]:
        return iter(self._verdicts)

    def __len__(self) -> int:
        return len(self._verdicts)

    @property
    def holds(self) -> bool:
        """Whether every equation holds."""
        return all(v.verdict == "holds" for v in self.values())

    def __str__(self) -> str:
        lines = [f"{v.equation:15} {v.verdict:10} {v.residual:+.2e} +- {v.bound:.0e}  {v.where}" for v in self.values()]
        return "\n".join([self.model, *lines])


def validate(model: Masking, wo: Any = None, tolerance: float = TOLERANCE) -> Validation:
    """A verdict for each of the seven equations. heitz2014.

    wo: view directions (..., 3), unit vectors above the horizon, at least one, taken in double precision; by default 8 polar
    angles from 0 to 89 degrees and 3 azimuths. tolerance: the largest relative residual that counts as rounding, above 0.
    ValueError for other views or tolerances, and for anything but a masking model.
    """
    if not isinstance(model, Masking):
        raise ValueError(f"model must be a model of masking such as Smith(GGX(0.3)), got {model!r}")
    tolerance = positive("tolerance", tolerance)
    views = default_views(model.ndf) if wo is None else _above(wo)
    verdicts = [
        *(_integral_verdict(name, *found, views, tolerance) for name, found in residuals(model, views).items()),
        *_pair_verdicts(Microfacet(model), tolerance),
        _energy_verdict(Microfacet(model), views, tolerance),
    ]
    return Validation(repr(model), verdicts)


def default_views(ndf: Distribution) -> np.ndarray:
    """View directions that a verdict rests on: one azimuth is enough for an isotropic distribution."""
    phi = PHI[:1] if ndf.isotropic else PHI
    return spherical(*np.meshgrid(THETA, phi, indexing="ij")).reshape(-1, 3)


def _above(wo: Any) -> np.ndarray:
    views = as_vectors("wo", wo).reshape(-1, 3).astype(np.float64)
    if not len(views):
        raise ValueError(f"wo must hold at least one direction, got shape {np.shape(wo)}")
    if not np.all(views[:, 2] > 0):
        raise ValueError(f"wo must lie above the horizon, got z = {views[:, 2].min()}")
    lengths = np.linalg.norm(views, axis=1)
    if np.any(off := abs(lengths - 1) > UNIT):
        raise ValueError(f"wo must be unit vectors, got length {lengths[off][0]:g}")
    return views


# --- the four validation equations --------------------------------------------------------------------------------------


@cache
def _seen(masked: Callable[..., float], normals: Callable[..., float]) -> Callable[..., float]:
    """What the visible area sums up, over the cosine."""

    def seen(view: float, ox: float, oy: float, oz: float, mx: float, my: float, mz: float, p: Any) -> float:
        cosine = ox * mx + oy * my + oz * mz
        return masked(view, ox, oy, oz, mx, my, mz, p) * cosine * normals(mx, my, mz, p[0]) / oz if cosine > 0.0 else 0.0

    return seen


@cache
def _mirrored(masked: Callable[..., float], normals: Callable[..., float]) -> Callable[..., float]:
    """What the weak white furnace sums up: the density of light directions at the mirror direction, times 4 wo.wm.

    It goes through the half vector of the light direction. What rounding leaves out of that direction is kept: near grazing,
    the half vector is small beside it.
    """

    def mirrored(view: float, ox: float, oy: float, oz: float, mx: float, my: float, mz: float, p: Any) -> float:
        cosine = ox * mx + oy * my + oz * mz
        if not cosine > 0.0:
            return 0.0
        ix, x_rest = two_sum(2.0 * cosine * mx, -ox)
        iy, y_rest = two_sum(2.0 * cosine * my, -oy)
        iz, z_rest = two_sum(2.0 * cosine * mz, -oz)
        hx, hy, hz = ox + ix + x_rest, oy + iy + y_rest, oz + iz + z_rest
        length = sqrt(hx * hx + hy * hy + hz * hz)
        hx, hy, hz = hx / length, hy / length, hz / length
        return reflected_density(masked(view, ox, oy, oz, hx, hy, hz, p), normals(hx, hy, hz, p[0]), oz) * 4.0 * cosine

    return mirrored


INTEGRALS = ("projected_area", "visible_area", "visible_norm", "weak_furnace")
ABOVE = np.array([0.0, 0.0, 1.0])


@cache
def _summed(masked: Callable[..., float], normals: Callable[..., float]) -> Callable[..., float]:
    """What any of `INTEGRALS` sums up; which of them, the last parameter tells, so that one kernel is compiled for all."""
    seen, visible, mirrored = _seen(masked, normals), visible_density(masked, normals), _mirrored(masked, normals)

    def summed(view: float, ox: float, oy: float, oz: float, mx: float, my: float, mz: float, p: Any) -> float:
        if p[2][0] == 0.0:
            return mz * normals(mx, my, mz, p[0])
        if p[2][0] == 1.0:
            return seen(view, ox, oy, oz, mx, my, mz, p)
        if p[2][0] == 2.0:
            return visible(view, ox, oy, oz, mx, my, mz, p)
        return mirrored(view, ox, oy, oz, mx, my, mz, p)

    return summed


def residual(model: Masking, equation: str, wo: Any) -> tuple[np.ndarray, np.ndarray]:
    """The relative residuals of one of the four validation equations at view directions (n, 3), and their errors.

    equation: one of `INTEGRALS`. The projected area, which no view changes, is taken from above. ValueError for any other
    equation, and for views that `validate` refuses.
    """
    one_of("equation", equation, INTEGRALS)
    views, normals = _above(wo), type(model.ndf).kernel
    level = equation == "projected_area"
    rule = seen_batch(model.view_kernel, _summed(model.masked_kernel, normals), normals)
    which = (float(INTEGRALS.index(equation)),)
    found = rule([ABOVE if level else views], ((*model.parameters, which), model.ndf.scale))
    values, bounds = found[..., 0] - 1, np.abs(found[..., 0] - found[..., 1]) + ROUNDING
    return (np.full(len(views), values), np.full(len(views), bounds)) if level else (values, bounds)


def residuals(model: Masking, wo: Any) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """`residual` of each of the four, by name."""
    return {equation: residual(model, equation, wo) for equation in INTEGRALS}


def _integral_verdict(name: str, values: np.ndarray, bounds: np.ndarray, views: np.ndarray, tolerance: float) -> Verdict:
    worst = int(np.argmax(np.abs(values)))
    where = "" if name == "projected_area" else _degrees("o", views[worst])
    return Verdict(name, decide(values, bounds, tolerance), float(values[worst]), float(bounds.max()), where)


def decide(values: np.ndarray, bounds: np.ndarray, tolerance: float) -> str:
    if np.any(np.abs(values) > tolerance + bounds):
        return "fails"
    return "holds" if np.all(np.abs(values) + bounds <= tolerance) else "undecided"


def _degrees(name: str, direction: np.ndarray) -> str:
    theta = np.degrees(np.arccos(np.clip(direction[2], -1, 1)))
    phi = np.degrees(np.arctan2(direction[1], direction[0])) % 360
    return f"theta_{name} = {theta:.4g}, phi_{name} = {phi:.4g}"


# --- the three classic equations ----------------------------------------------------------------------------------------

reflected_density = reflected.scalar
PAIRS = 20000


def _pairs() -> tuple[np.ndarray, np.ndarray]:
    """Pairs of directions, uniform in solid angle over the hemisphere."""
    u = np.random.default_rng(0).random((4, PAIRS))
    return spherical(np.arccos(u[0]), 2 * np.pi * u[1]), spherical(np.arccos(u[2]), 2 * np.pi * u[3])


def _pair_verdicts(brdf: Microfacet, tolerance: float) -> list[Verdict]:
    wo, wi = _pairs()
    there, back = brdf.evaluate(wo, wi), brdf.evaluate(wi, wo)
    scale = np.maximum(np.abs(there), np.finfo(float).tiny)
    lowest, apart = np.minimum(there / scale, 0), (there - back) / scale
    return [
        _pair_verdict("positivity", lowest, wo, wi, tolerance),
        _pair_verdict("reciprocity", apart, wo, wi, tolerance),
    ]


def _pair_verdict(name: str, values: np.ndarray, wo: np.ndarray, wi: np.ndarray, tolerance: float) -> Verdict:
    worst = int(np.argmax(np.abs(values)))
    verdict = decide(values, np.full(len(values), ROUNDING), tolerance)
    return Verdict(name, verdict, float(values[worst]), ROUNDING, f"{_degrees('o', wo[worst])}, {_degrees('i', wi[worst])}")


def _energy_verdict(brdf: Microfacet, views: np.ndarray, tolerance: float) -> Verdict:
    """The largest albedo, less 1: only what is above 0 breaks the equation."""
    fine, bounds = brdf.albedo_with_error(views)
    worst = int(np.argmax(fine))
    excess = np.maximum(fine - 1, 0)
    verdict = (
        "fails" if np.any(excess > tolerance + bounds) else "holds" if np.all(fine + bounds <= 1 + tolerance) else "undecided"
    )
    return Verdict("energy", verdict, float(fine[worst] - 1), float(bounds[worst]), _degrees("o", views[worst]))
