"""A scene to choose a model for: ranges of roughness and angle, the material, and the bounces that count."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from microfacet.directions import one_of, real_number, spherical
from microfacet.families import alphas_of, families, key_of, of_alpha
from microfacet.geometry.slopes import Distribution
from microfacet.material.fresnel import Dielectric, Fresnel, Mirror

Array = NDArray[np.float64]
Range = tuple[float, float]

PRECISIONS = {"double": (np.float64,), "single": (np.float32,), "either": (np.float64, np.float32)}
BOUNCES = ("all", "one")
ALPHAS, THETAS = 3, 5  # samples in a range of roughness and of the view's angle
VIEW_AZIMUTHS = (0.0, 45.0, 90.0)  # degrees, of the views of an anisotropic surface


def normals_by_name() -> dict[str, type[Distribution]]:
    """Every family of distributions with a roughness, GGX and Beckmann first."""
    return {key_of(kind): kind for kind in families(Distribution, ("GGX", "Beckmann")) if alphas_of(kind)}


class Point(NamedTuple):
    """One roughness viewed from one direction: alpha_x, alpha_y, the view's polar angle and azimuth in degrees."""

    alpha_x: float
    alpha_y: float
    theta: float
    phi: float

    @property
    def wo(self) -> Array:
        """The unit vector towards the viewer, (3,)."""
        return spherical(math.radians(self.theta), math.radians(self.phi))

    @property
    def isotropic(self) -> bool:
        return self.alpha_x == self.alpha_y

    def ndf(self, normals: str) -> Distribution:
        """The distribution of that name with this roughness."""
        return of_alpha(normals_by_name()[normals], self.alpha_x, self.alpha_y)


@dataclass(frozen=True)
class Scene:
    """Scene that `choose` compares models on; a range is two numbers, or one for both.

    Parameters
    ----------
    alpha : float or pair of float
        Range of the larger roughness.
    theta : float or pair of float, optional
        Range of the polar angle of the view, degrees, in [0, 90).
    ratio : float or pair of float, optional
        Range of the larger roughness over the smaller, from 1.
    light : float or pair of float, optional
        Range of the polar angle of the light, degrees, in [0, 90]; light from elsewhere does not count.
    normals : str, optional
        Distribution of the surface: ``"ggx"``, ``"beckmann"``, or the name of another family that is made of roughness.
    fresnel : Dielectric or Conductor, optional
        Reflectance; by default that of a perfect mirror.
    bounces : {"all", "one"}, optional
        Whether light that bounces several times counts.
    precision : {"double", "single", "either"}, optional
        Precision of the candidates.

    Raises
    ------
    ValueError
        For anything else.
    """

    alpha: Any
    theta: Any = (0.0, 80.0)
    ratio: Any = 1.0
    light: Any = (0.0, 90.0)
    normals: str = "ggx"
    fresnel: Fresnel | None = None
    bounces: str = "all"
    precision: str = "either"

    def __post_init__(self) -> None:
        limits = {
            "alpha": (0.0, math.inf),
            "theta": (-1e-300, 90.0),
            "ratio": (1 - 1e-15, math.inf),
            "light": (-1e-300, 90 + 1e-13),
        }
        for name, (above, below) in limits.items():
            object.__setattr__(self, name, as_range(name, getattr(self, name), above, below))
        if self.light[0] == self.light[1]:
            raise ValueError(f"light must be a range of more than one angle, got {self.light[0]:g}")
        for name, known in (("normals", normals_by_name()), ("bounces", BOUNCES), ("precision", PRECISIONS)):
            one_of(name, getattr(self, name), known)
        if alphas_of(self.family) == 1 and self.ratio != (1.0, 1.0):
            raise ValueError(
                f"ratio must be 1 for {self.family.label}, which has one roughness, got {_range_label(self.ratio)}"
            )
        if self.bounces == "all" and self.family.facet_kernel is None:
            raise ValueError(f'bounces must be "one" for {self.family.label}: its class has no facet_kernel to follow light by')
        if not (self.fresnel is None or isinstance(self.fresnel, Fresnel)):
            raise ValueError(f"fresnel must be None, Dielectric or Conductor, got {self.fresnel!r}")
        if not self.material.F(1.0) > 0:
            raise ValueError(f"fresnel must reflect light, which an index of 1 does not, got {material_label(self.material)}")

    @property
    def family(self) -> type[Distribution]:
        return normals_by_name()[self.normals]

    @cached_property
    def material(self) -> Fresnel:
        return Mirror() if self.fresnel is None else self.fresnel

    @cached_property
    def points(self) -> tuple[Point, ...]:
        """Where the models are compared: the ends of all ranges, and samples between."""
        return self.grid(ALPHAS, THETAS)

    def grid(self, alphas: int, thetas: int) -> tuple[Point, ...]:
        """`alphas` roughnesses in equal ratios and `thetas` angles in equal steps; anisotropies at both ends of their range."""
        rough = _spread(self.alpha, alphas, np.geomspace)
        views = _spread(self.theta, thetas, np.linspace)
        pairs = [(a, a / r) for r in dict.fromkeys(self.ratio) for a in rough]
        return tuple(
            Point(x, y, theta, phi) for x, y in pairs for theta in views for phi in ((0.0,) if x == y else VIEW_AZIMUTHS)
        )

    def illuminates(self, wi: Array) -> NDArray[np.bool_]:
        """Which of the light directions (..., 3) lie in the scene's range of light."""
        theta = np.degrees(np.arctan2(np.hypot(wi[..., 0], wi[..., 1]), wi[..., 2]))
        inside: NDArray[np.bool_] = (theta >= self.light[0]) & (theta <= self.light[1]) & (wi[..., 2] > 0)
        return inside

    def illuminated_fraction(self, theta: Array, reach: Array) -> Array:
        """The fraction of the polar angles theta - reach to theta + reach, degrees, that lies in the scene's range of light."""
        low, high = np.maximum(theta - reach, 0.0), np.minimum(theta + reach, 90.0)
        inside = np.maximum(np.minimum(high, self.light[1]) - np.maximum(low, self.light[0]), 0.0)
        alone = ((theta >= self.light[0]) & (theta <= self.light[1])).astype(float)
        fraction: Array = np.divide(inside, high - low, out=alone, where=high > low)
        return fraction

    def __str__(self) -> str:
        parts = [
            f"alpha {_range_label(self.alpha)}",
            f"views {_range_label(self.theta)} degrees",
            f"{self.bounces} bounce{'s' * (self.bounces == 'all')}",
        ]
        parts += [f"ratio {_range_label(self.ratio)}"] if self.ratio != (1.0, 1.0) else []
        parts += [f"light {_range_label(self.light)} degrees"] if self.light != (0.0, 90.0) else []
        return f"{self.family.__name__}, {material_label(self.material)}, {', '.join(parts)}"


def material_label(fresnel: Fresnel) -> str:
    """The reflectance by name: `conductor 0.2 + 3.9i`."""
    if isinstance(fresnel, Mirror):
        return "perfect mirrors"
    numbers = [f"{value:g}" for value in fresnel.parameters]
    kind = "dielectric" if isinstance(fresnel, Dielectric) else type(fresnel).__name__.lower()
    return f"{kind} {' + '.join(numbers)}{'i' * (len(numbers) == 2)}"


def as_range(name: str, given: Any, above: float, below: float) -> Range:
    """Two numbers in order, above and below the bounds; one stands for both."""
    try:
        ends = tuple(map(real_number, (given, given) if np.ndim(given) == 0 else given))
    except (TypeError, ValueError):
        raise ValueError(f"{name} must be a number or a range such as (0.1, 0.3), got {given!r}") from None
    if len(ends) != 2 or not all(map(math.isfinite, ends)):
        raise ValueError(f"{name} must be a number or a range such as (0.1, 0.3), got {given!r}")
    if ends[0] > ends[1]:
        raise ValueError(f"{name} must be a range from low to high, got {ends[0]:g} to {ends[1]:g}")
    if not (above < ends[0] and ends[1] < below):
        raise ValueError(f"{name} must lie {BETWEEN[name]}, got {_range_label(ends)}")
    return ends[0], ends[1]


BETWEEN = {
    "alpha": "above 0",
    "theta": "at or above 0 and below 90 degrees",
    "ratio": "at or above 1",
    "light": "between 0 and 90 degrees",
}


def _spread(ends: Range, count: int, spacing: Any) -> list[float]:
    """`count` numbers from one end to the other, the ends exactly; one if they are the same."""
    return [ends[0]] if ends[0] == ends[1] else [ends[0], *map(float, spacing(*ends, count)[1:-1]), ends[1]]


def _range_label(ends: Sequence[float]) -> str:
    return f"{ends[0]:g}" if ends[0] == ends[1] else f"{ends[0]:g} to {ends[1]:g}"
