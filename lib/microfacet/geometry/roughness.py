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
    r"""Convert a roughness of a named convention to alpha.

    =============  =====================================  ============================================
    Convention     Alpha                                  Used by
    =============  =====================================  ============================================
    ``"squared"``  :math:`r^2`                            glTF, Disney, Filament, Unreal, Blender
    ``"alpha"``    :math:`r`                              Mitsuba
    ``"pbrt-v3"``  a fit in :math:`\ln \max(r, 0.001)`    pbrt-v3
    ``"pbrt-v4"``  :math:`\sqrt{r}`                       pbrt-v4
    ``"phong"``    :math:`\sqrt{2/(r + 2)}`               exponents of Phong and Blinn
    =============  =====================================  ============================================

    The fit is :math:`1.62142 + 0.819955 x + 0.1734 x^2 + 0.0171201 x^3 + 0.000640711 x^4` with :math:`x = \ln \max(r, 0.001)`.

    Parameters
    ----------
    roughness : array_like
        Roughness, dimensionless, in (0, 1]; above 0 for ``"alpha"`` and ``"phong"``.
    convention : str, optional
        One of those in the table; by default ``"squared"``.

    Returns
    -------
    ndarray
        Alpha, dimensionless, of the same shape and precision.

    Raises
    ------
    ValueError
        For another convention, and for a roughness outside its range.

    References
    ----------
    burley2012; walter2007; pharr2016; pharr2023.

    Examples
    --------
    >>> import microfacet as mf
    >>> print(mf.alpha_from_roughness(0.5), mf.alpha_from_roughness(100, "phong").round(4))
    0.25 0.14
    """
    values = numbers("roughness", roughness).checked()
    rule = CONVENTIONS[one_of("convention", convention, CONVENTIONS)]
    highest = np.inf if convention in ("alpha", "phong") else 1
    if values.size and not (values.min() > 0 and values.max() <= highest):
        kind = "above 0" if highest == np.inf else "in (0, 1]"
        raise ValueError(f"roughness must be {kind} by the convention {convention!r}, got {values.min():g} to {values.max():g}")
    return rule(values)[()]


def stretched_alpha(alpha: ArrayLike, anisotropic: ArrayLike) -> tuple[NDArray[Any], NDArray[Any]]:
    r"""Convert alpha and a degree of anisotropy to roughness along x and along y.

    .. math:: \alpha_x = \alpha/s, \quad \alpha_y = \alpha s, \quad s = \sqrt{1 - 0.9 \, a}

    with the degree of anisotropy a.

    Parameters
    ----------
    alpha : array_like
        Roughness, dimensionless, above 0.
    anisotropic : array_like
        Degree of anisotropy in [0, 1]; shapes broadcast.

    Returns
    -------
    alpha_x : ndarray
        Roughness along x, the larger one.
    alpha_y : ndarray
        Roughness along y.

    Raises
    ------
    ValueError
        If alpha or anisotropic is outside its range.

    References
    ----------
    burley2012.

    Examples
    --------
    >>> import microfacet as mf
    >>> alpha_x, alpha_y = mf.stretched_alpha(0.2, 0.8)
    >>> print(f"{alpha_x:.4f} {alpha_y:.4f}")
    0.3780 0.1058
    """
    values, amount = numbers("alpha", alpha).checked(), numbers("anisotropic", anisotropic).checked()
    if values.size and not values.min() > 0:
        raise ValueError(f"alpha must be above 0, got {values.min():g}")
    if amount.size and not (amount.min() >= 0 and amount.max() <= 1):
        raise ValueError(f"anisotropic must lie in [0, 1], got {amount.min():g} to {amount.max():g}")
    aspect = np.sqrt(1 - 0.9 * amount)
    return (values / aspect)[()], (values * aspect)[()]
