"""From the roughness that a file or an artist gives to the alpha of a distribution: conventions differ, so each has a name."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microfacet.directions import numbers, one_of


class Alphas(NamedTuple):
    """Parameters of a distribution that is stretched: its roughness along both axes."""

    alpha_x: float
    alpha_y: float


class SlopeScale(NamedTuple):
    """How far slopes spread along both axes, for quadratures."""

    scale_x: float
    scale_y: float


PBRT3 = (1.62142, 0.819955, 0.1734, 0.0171201, 0.000640711)  # RoughnessToAlpha of pbrt-v3, in powers of ln(roughness)
LEAST_PBRT3 = 1e-3


def _pbrt3(roughness: Any) -> Any:
    x = np.log(np.maximum(roughness, roughness.dtype.type(LEAST_PBRT3)))
    total = np.zeros_like(x)
    for coefficient in reversed(PBRT3):
        total = total * x + x.dtype.type(coefficient)
    return total


CONVENTIONS: dict[str, Callable[[Any], Any]] = {
    "squared": np.square,
    "alpha": np.asarray,
    "pbrt-v3": _pbrt3,
    "pbrt-v4": np.sqrt,
    "phong": lambda n: np.sqrt(2 / (n + 2)),
}


def alpha_from_roughness(roughness: ArrayLike, convention: str = "squared") -> NDArray[Any]:
    """The alpha that a roughness stands for by a convention; any shape, float32 in gives float32 out.

    "squared": alpha = r^2, of Disney's materials, glTF, Filament, Unreal and Blender (burley2012). "alpha": alpha itself, as in
    Mitsuba (walter2007). "pbrt-v3": the fit 1.62142 + 0.819955 x + 0.1734 x^2 + 0.0171201 x^3 + 0.000640711 x^4 with
    x = ln max(r, 0.001) (pharr2016). "pbrt-v4": alpha = sqrt r (pharr2023). "phong": the exponent n of a cosine, of a Beckmann
    surface with the same highlight: alpha = sqrt(2/(n + 2)) (walter2007).
    ValueError for other conventions, for a roughness that is not above 0 and for one above 1, where it is no exponent.
    """
    values = numbers("roughness", roughness).checked()
    rule = CONVENTIONS[one_of("convention", convention, CONVENTIONS)]
    highest = np.inf if convention in ("alpha", "phong") else 1
    if values.size and not (values.min() > 0 and values.max() <= highest):
        kind = "above 0" if highest == np.inf else "in (0, 1]"
        raise ValueError(f"roughness must be {kind} by the convention {convention!r}, got {values.min():g} to {values.max():g}")
    return rule(values)[()]


def stretched_alpha(alpha: ArrayLike, anisotropic: ArrayLike) -> tuple[NDArray[Any], NDArray[Any]]:
    """alpha_x and alpha_y of a surface rougher along x than along y, from alpha and a number in [0, 1]. burley2012.

    Shapes broadcast; alpha_x = alpha/aspect and alpha_y = alpha aspect, with aspect = sqrt(1 - 0.9 anisotropic).
    """
    values, amount = numbers("alpha", alpha).checked(), numbers("anisotropic", anisotropic).checked()
    if values.size and not values.min() > 0:
        raise ValueError(f"alpha must be above 0, got {values.min():g}")
    if amount.size and not (amount.min() >= 0 and amount.max() <= 1):
        raise ValueError(f"anisotropic must lie in [0, 1], got {amount.min():g} to {amount.max():g}")
    aspect = np.sqrt(1 - 0.9 * amount)
    return (values / aspect)[()], (values * aspect)[()]
