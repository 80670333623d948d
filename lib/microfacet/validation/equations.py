"""Is a model a microfacet model? The four validation equations of the talk, and the three classic ones."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from microfacet.brdf.albedo import KNOWN
from microfacet.brdf.microfacet import Microfacet
from microfacet.directions import as_vectors, one_of, positive, spherical
from microfacet.geometry.panels import Panels
from microfacet.geometry.slopes import Distribution
from microfacet.validation.over_panels import FEW_SAMPLES, MANY_SAMPLES, ROUNDING, Kernels, Sight, Sights
from microfacet.visibility.masking import Masking
from microfacet.visibility.smith import Smith

TOLERANCE = 1e-9  # largest relative residual that counts as rounding and quadrature
ISOTROPY_TOLERANCE = 1e-7  # largest difference of an isotropic D between azimuths, relative to its maximum on the ring

THETA = np.radians([0, 15, 30, 45, 60, 75, 85, 89])
AZIMUTH_COUNT = 6  # of the views at each polar angle
GOLDEN = 0.6180339887498949  # of a full circle from one azimuth to the next: no symmetry hides between them
GRAZING_COTANGENTS = (0.5, 0.125)  # cotangents, in slope scales, at which the facets of any surface mask each other
TOWARDS = np.radians([60, 85])  # polar angles of the views along and against lobes that lean
LOBES = 2  # number of lobes viewed so

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
    """Verdict of one validation equation on a model.

    Attributes
    ----------
    equation : str
        Name of the equation.
    verdict : str
        ``"holds"``, ``"fails"``, or ``"undecided"`` where the error is too large to tell.
    residual : float
        Worst relative deviation from the equation.
    bound : float
        Its error, estimated from how integrands fall and from rounding, not proved.
    where : str
        Direction, or pair of them, of the residual, in degrees.
    rests_on : str
        Directions and resolution that were tested.
    """

    equation: str
    verdict: str
    residual: float
    bound: float
    where: str
    rests_on: str = ""

    @property
    def needs(self) -> str:
        """Remedy for an undecided equation; otherwise empty."""
        if self.verdict != "undecided":
            return ""
        needed = abs(self.residual) + self.bound
        return f"a tolerance of {needed:.1e}, or a D with fewer or wider features and less rounding, would decide it"

    @property
    def title(self) -> str:
        """The equation in words."""
        return TITLES[self.equation]


class Validation(Mapping[str, Verdict]):
    """Verdicts on one model: a mapping from the names of the equations, which prints as a table."""

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
        lines = [
            f"{v.equation:15} {v.verdict:10} {v.residual:+.2e} +- {v.bound:.0e}  {v.needs or v.where}" for v in self.values()
        ]
        resting: dict[str, list[str]] = {}
        for v in self.values():
            resting.setdefault(v.rests_on, []).append(v.equation)
        return "\n".join([self.model, *lines, *(f"{', '.join(names)}: {what}" for what, names in resting.items())])


def validate(model: Masking, wo: Any = None, tolerance: float = TOLERANCE) -> Validation:
    """Test whether a model obeys the seven validation equations.

    Four are of the normals and their visibility (``projected_area``, ``visible_area``, ``visible_norm``, ``weak_furnace``),
    three of the BRDF with F = 1 (``positivity``, ``reciprocity``, ``energy``).

    Parameters
    ----------
    model : Masking
        Model of masking and shadowing, with numbers for parameters.
    wo : array_like, shape (..., 3), optional
        View directions above the horizon, unit vectors. By default 8 polar angles from 0 to 89 degrees, each from azimuths
        of its own; for smooth surfaces also angles at which microfacets mask each other, and views along lobes that lean.
    tolerance : float, optional
        Largest relative residual that counts as rounding, above 0.

    Returns
    -------
    Validation
        A mapping from the names of the equations to a `Verdict` each.

    Raises
    ------
    ValueError
        For other arguments, where D is not finite, and for a distribution that claims to be isotropic and is not.

    References
    ----------
    heitz2014.

    Examples
    --------
    >>> import microfacet as mf
    >>> mf.validate(mf.Smith(mf.GGX(0.3))).holds
    True
    >>> verdict = mf.validate(mf.Kelemen(mf.GGX(0.3)))["visible_area"]
    >>> print(verdict.verdict, f"{verdict.residual:+.3f}", verdict.where)
    fails -0.382 theta_o = 89, phi_o = 117.4
    """
    if not isinstance(model, Masking):
        raise ValueError(f"model must be a model of masking such as Smith(GGX(0.3)), got {model!r}")
    model.require_numbers("validate")
    tolerance = positive("tolerance", tolerance)
    views = default_views(model.ndf) if wo is None else _above(wo)
    sights = Sights(model)
    if model.ndf.isotropic:
        _require_isotropy(model.ndf, sights)
    by_view, rests_on = sights(views), _evidence(model.ndf, views)
    level = f"D at {model.ndf.panels.evaluations} normals, features down to {_finest(model.ndf.panels)} wide in slope"
    return Validation(
        repr(model),
        [
            _level_verdict(model.ndf.panels, tolerance, level),
            *(_integral_verdict(name, *_of(by_view, name), views, tolerance, rests_on) for name in INTEGRALS[1:]),
            *_pair_verdicts(sights, tolerance),
            _energy_verdict(model, by_view, views, tolerance, rests_on),
        ],
    )


def default_views(ndf: Distribution) -> np.ndarray:
    """View directions that a verdict rests on: for an isotropic distribution one of each polar angle, otherwise many azimuths.

    All azimuths differ, and no symmetry maps one to another. Smooth surfaces are also viewed so near the horizon that their
    facets mask each other. Without isotropy, lobes that lean are viewed along, against and across their azimuth.
    """
    azimuths = 1 if ndf.isotropic else AZIMUTH_COUNT
    theta = np.array([THETA[0], *np.tile(THETA[1:], azimuths)])
    views = [spherical(theta, _spread(len(theta))), _grazing(ndf.slope_scale, azimuths)]
    if not ndf.isotropic:
        views += [
            spherical(t, phi + offset)[None]
            for phi in _leaning(ndf.panels)
            for t in TOWARDS
            for offset in (0, np.pi / 2, np.pi)
        ]
    return np.concatenate(views)


def _spread(count: int) -> np.ndarray:
    return np.asarray(2 * np.pi * GOLDEN * np.arange(count))


def _grazing(scale: tuple[float, float], azimuths: int) -> np.ndarray:
    """Views beyond the last polar angle whose cotangent is comparable to the slopes along their azimuth."""
    cot = np.tile(GRAZING_COTANGENTS, azimuths)
    phi = _spread(len(cot))
    theta = np.arctan2(1, cot * np.hypot(scale[0] * np.cos(phi), scale[1] * np.sin(phi)))
    beyond = theta > THETA[-1]
    return spherical(theta[beyond], phi[beyond])


def _leaning(panels: Panels) -> list[float]:
    """Azimuths of the views that face the panels with most facets: those of lobes that lean."""
    area, x, y = panels.moments.T
    azimuths: list[float] = []
    for k in np.argsort(-area * np.hypot(x / panels.scale[0], y / panels.scale[1])):
        azimuth = float(np.arctan2(-y[k], -x[k]))
        if all(abs(np.angle(np.exp(1j * (azimuth - other)))) > np.pi / 6 for other in azimuths):
            azimuths.append(azimuth)
        if len(azimuths) == LOBES:
            break
    return azimuths


def _finest(panels: Panels) -> str:
    """Spacing of the points at which D was surveyed, in slopes."""
    return f"{panels.closest * panels.scale[0]:.1g} by {panels.closest * panels.scale[1]:.1g}"


def _evidence(ndf: Distribution, views: np.ndarray) -> str:
    """The views that a verdict on integrals rests on, in words."""
    polar = len(np.unique(np.round(views[:, 2], 9)))
    azimuths = np.unique(np.round(np.degrees(np.arctan2(views[:, 1], views[:, 0])) % 360, 6))
    gaps = np.diff([*azimuths, azimuths[0] + 360])
    symmetry = (
        "isotropy, declared and checked" if ndf.isotropic else f"no symmetry, azimuths at most {gaps.max():.0f} degrees apart"
    )
    return f"{len(views)} views, {polar} polar angles, {len(azimuths)} azimuths; {symmetry}"


RINGS, RING_AZIMUTHS = 512, 61  # normals at which isotropy is checked, and azimuths of each


def _require_isotropy(ndf: Distribution, sights: Sights) -> None:
    """A ValueError if D changes with azimuth, at normals spread over the facets."""
    normals = sights.spread(RINGS)
    azimuths = 2 * np.pi * (GOLDEN * np.arange(1, RING_AZIMUTHS + 1))[:, None]
    x, y, z = normals.T
    rotated = np.stack(
        [x * np.cos(azimuths) - y * np.sin(azimuths), x * np.sin(azimuths) + y * np.cos(azimuths), z + 0 * azimuths], axis=-1
    )
    values = np.concatenate([ndf.D(normals)[None], ndf.D(rotated)])
    apart = np.ptp(values, axis=0) / np.maximum(np.abs(values).max(axis=0), np.finfo(float).tiny)
    worst = int(np.argmax(apart))
    if apart[worst] > ISOTROPY_TOLERANCE:
        theta = np.degrees(np.arctan2(np.hypot(x[worst], y[worst]), z[worst]))
        differs = f"its D differs by {apart[worst]:.1%} between azimuths at theta_m = {theta:.4g}"
        raise ValueError(f"{ndf!r} says that it is isotropic, but {differs}")


def _above(wo: Any) -> np.ndarray:
    views = as_vectors("wo", wo).reshape(-1, 3).astype(np.float64)
    if not len(views):
        raise ValueError(f"wo must hold at least one direction, got shape {np.shape(wo)}")
    if not np.all(views[:, 2] > 0):
        raise ValueError(f"wo must lie above the horizon, got z = {views[:, 2].min()}")
    return np.asarray(views / np.linalg.norm(views, axis=1, keepdims=True))


# --- the four validation equations --------------------------------------------------------------------------------------

INTEGRALS = ("projected_area", "visible_area", "visible_norm", "weak_furnace")
ABOVE = np.array([0.0, 0.0, 1.0])  # a view that no masking changes


def _of(by_view: list[Sight], equation: str) -> tuple[np.ndarray, np.ndarray]:
    """Residuals of one of the three equations that depend on the view, and their errors."""
    sums = np.array(
        [
            getattr(sight, {"visible_area": "area", "visible_norm": "norm", "weak_furnace": "furnace"}[equation])
            for sight in by_view
        ]
    )
    return sums[:, 0] - 1, sums[:, 1]


def residual(model: Masking, equation: str, wo: Any) -> tuple[np.ndarray, np.ndarray]:
    """The relative residuals of one of the four validation equations at view directions (n, 3), and their errors.

    equation: one of `INTEGRALS`. No view changes the projected area. ValueError for any other equation, and for views that
    `validate` refuses.
    """
    one_of("equation", equation, INTEGRALS)
    return residuals(model, wo, (equation,))[equation]


def residuals(model: Masking, wo: Any, equations: tuple[str, ...] = INTEGRALS) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """`residual` of each of the four, by name."""
    views, panels = _above(wo), model.ndf.panels
    level = np.full(len(views), panels.area - 1), np.full(len(views), panels.error + ROUNDING)
    sights = Sights(model)(views) if set(equations) - {INTEGRALS[0]} else []
    return {name: level if name == INTEGRALS[0] else _of(sights, name) for name in equations}


def _level_verdict(panels: Panels, tolerance: float, rests_on: str) -> Verdict:
    value, bound = panels.area - 1, panels.error + ROUNDING
    return Verdict(INTEGRALS[0], decide(np.array([value]), np.array([bound]), tolerance), value, bound, "", rests_on)


def _integral_verdict(
    name: str, values: np.ndarray, bounds: np.ndarray, views: np.ndarray, tolerance: float, rests_on: str
) -> Verdict:
    worst = int(np.argmax(np.abs(values)))
    verdict = decide(values, bounds, tolerance)
    return Verdict(name, verdict, float(values[worst]), float(bounds.max()), _degrees("o", views[worst]), rests_on)


def decide(values: np.ndarray, bounds: np.ndarray, tolerance: float) -> str:
    if np.any(np.abs(values) > tolerance + bounds):
        return "fails"
    return "holds" if np.all(np.abs(values) + bounds <= tolerance) else "undecided"


def _degrees(name: str, direction: np.ndarray) -> str:
    theta = np.degrees(np.arccos(np.clip(direction[2], -1, 1)))
    phi = np.degrees(np.arctan2(direction[1], direction[0])) % 360
    return f"theta_{name} = {theta:.4g}, phi_{name} = {phi:.4g}"


# --- the three classic equations ----------------------------------------------------------------------------------------

DIRECTIONS = 201
PAIRS = DIRECTIONS * (DIRECTIONS - 1) // 2


def _directions() -> np.ndarray:
    """Directions uniform in solid angle over the hemisphere."""
    u = np.random.default_rng(0).random((2, DIRECTIONS))
    return spherical(np.arccos(u[0]), 2 * np.pi * u[1])


def _pair_verdicts(sights: Sights, tolerance: float) -> list[Verdict]:
    """Verdicts on all pairs of directions, each as viewer and light and the other way round, and on D at all its nodes."""
    wo, wi, there, back = _both_ways(sights.kernels)
    scale = np.maximum(np.abs(there), np.finfo(float).tiny)
    negative, normal = sights.negative()
    rests_on = f"{PAIRS} pairs of {DIRECTIONS} directions"
    positive_pairs = _pair_verdict("positivity", np.minimum(there / scale, 0), wo, wi, tolerance, rests_on)
    if -negative < positive_pairs.residual:
        verdict = decide(np.array([-negative]), np.array([ROUNDING]), tolerance)
        positive_pairs = Verdict(
            "positivity", verdict, -negative, ROUNDING, _degrees("m", normal), f"{rests_on}, and the area of D below 0"
        )
    return [positive_pairs, _pair_verdict("reciprocity", (there - back) / scale, wo, wi, tolerance, rests_on)]


def _both_ways(kernels: Kernels) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Pairs of directions, and G2 at their half vector for one as viewer, then for the other."""
    directions = _directions()
    Lambda = kernels.Lambda([directions], kernels.parameters)
    first, second = np.triu_indices(DIRECTIONS, 1)
    wo, wi = directions[first], directions[second]
    h = (wo + wi) / np.linalg.norm(wo + wi, axis=1, keepdims=True)
    there = kernels.G2([Lambda[first], Lambda[second], wo, wi, h], kernels.parameters)
    return wo, wi, there, kernels.G2([Lambda[second], Lambda[first], wi, wo, h], kernels.parameters)


def _pair_verdict(name: str, values: np.ndarray, wo: np.ndarray, wi: np.ndarray, tolerance: float, rests_on: str) -> Verdict:
    worst = int(np.argmax(np.abs(values)))
    verdict = decide(values, np.full(len(values), ROUNDING), tolerance)
    where = f"{_degrees('o', wo[worst])}, {_degrees('i', wi[worst])}"
    return Verdict(name, verdict, float(values[worst]), ROUNDING, where, rests_on)


def _energy_verdict(model: Masking, by_view: list[Sight], views: np.ndarray, tolerance: float, rests_on: str) -> Verdict:
    """The largest albedo, less 1: only a positive residual breaks the equation."""
    values, bounds, method = _albedos(model, by_view, views)
    highest = np.minimum(values + bounds, [sight.limit for sight in by_view])
    worst = int(np.argmax(values))
    fails, holds = np.any(values - bounds > 1 + tolerance), np.all(highest <= 1 + tolerance)
    verdict = "fails" if fails else "holds" if holds else "undecided"
    where = _degrees("o", views[worst])
    return Verdict("energy", verdict, float(values[worst] - 1), float(bounds[worst]), where, f"{rests_on}; {method}")


def _albedos(model: Masking, by_view: list[Sight], views: np.ndarray) -> tuple[np.ndarray, np.ndarray, str]:
    """By quadrature where kinks are known and masking has a closed form; elsewhere, where it is slow, from a few normals."""
    reflected = Microfacet(model).reflected
    closed = not isinstance(model, Smith) or type(model.ndf).closed_Lambda is not None
    if closed and reflected.effort == KNOWN:
        return *reflected(views), "albedos by quadrature"
    values, bounds = np.array([sight.albedo for sight in by_view]).T
    return values, bounds, f"light followed from {FEW_SAMPLES} to {MANY_SAMPLES} normals each"
