"""Masking: the visible fraction of a facet, and the base class of masking models.

To add a model, write a file like v_cavity.py: its statements, and a class that names its kernels.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import sympy as sp
from numpy.typing import ArrayLike, NDArray

from microfacet.compiler.batch import Batch
from microfacet.compiler.kernels import Parameters, Vector
from microfacet.directions import uniform, vectors
from microfacet.geometry.slopes import Distribution, normals_integral
from microfacet.geometry.visible_normals import HORIZON
from microfacet.parameters import Parametric
from microfacet.statements.notation import G1, D, mu_o, om, printed_symbol
from microfacet.statements.statement import Equation

# --- statements ---------------------------------------------------------------------------------------------------

seen = printed_symbol("A_plus", r"A^{+}", positive=True)  # projected area of all facets turned to the viewer
hidden = printed_symbol("A_minus", r"A^{-}", positive=True)  # projected area of all facets turned away

SHAPES = ("beckmann", "ggx", "normalized_blinn_phong")
MODELS = tuple(f"validation.table2.{masking}_{shape}" for masking in ("smith", "v_cavity") for shape in SHAPES)

with sp.evaluate(False):
    conservation = Equation(
        key="visibility.masking.projected_area",
        title="visible facets project to the area of the surface",
        symbol=normals_integral(r"G_1(\omega_o, \omega_m) \left\langle \omega_o, \omega_m \right\rangle D(\omega_m)"),
        equals=mu_o,
        enclosed=MODELS,
        slides=(39, 40),
        cite="heitz2014",
        note="The second validation equation; each model below is put to it.",
    )
    visible_normals = Equation(
        key="visibility.masking.D_visible",
        title="the distribution of visible normals",
        symbol=printed_symbol("D_visible", r"D_{\omega_o}(\omega_m)"),
        equals=G1 * om * D / mu_o,
        over={G1: (0, 1), om: (1e-9, 1), D: (1e-6, 1e6), mu_o: (1e-8, 1)},
        slides=(41, 42, 43),
        cite="heitz2014",
    )
    visible_norm = Equation(
        key="visibility.masking.visible_norm",
        title="visible normals are a distribution",
        symbol=normals_integral(r"D_{\omega_o}(\omega_m)"),
        equals=sp.Integer(1),
        enclosed=MODELS,
        slides=(42, 43),
        cite="heitz2014",
        note="The third validation equation: the second, divided by the cosine.",
    )

# --- the base class of models -----------------------------------------------------------------------------------------


class ModelParameters(NamedTuple):
    """What the kernels of a model take last: the parameters of its distribution, and its own."""

    ndf: Any
    model: Any


def no_Lambda(w: Vector, p: ModelParameters) -> float:
    """In place of Lambda for a model without it, whose masking has a formula of its own."""
    return 0.0


class Masking(Parametric):
    r"""Base class of the models of masking and shadowing over a distribution of normals.

    A physical masking function conserves the projected area that a viewer sees,

    .. math:: \int_{\Omega} G_1(\omega_o, \omega_m) \left\langle \omega_o, \omega_m \right\rangle D(\omega_m) \, d\omega_m
              = \cos\theta_o,

    statement ``visibility.masking.projected_area``, which `validate` checks.

    A subclass gives kernels: ``Lambda_kernel``, which is computed once for each direction (by default 0); ``G1_kernel``,
    given Lambda; ``G2_kernel``, given that of both directions. The last two also take the cosines between directions and
    normal, which are above 0, and not the dot products, whose sign rounding decides at grazing angles.

    Parameters
    ----------
    ndf : Distribution
        Distribution of normals.
    own : tuple, optional
        Parameters of the model itself, best a named tuple.

    Attributes
    ----------
    parameters : tuple
        What the kernels take last: ``ndf``, the parameters of the distribution, and ``model``, those of the model.

    Raises
    ------
    ValueError
        If ndf is not a distribution.

    See Also
    --------
    Smith : Normals and heights that do not depend on each other.
    VCavity : Grooves of two facets.

    References
    ----------
    heitz2014.

    Examples
    --------
    >>> import microfacet as mf
    >>> isinstance(mf.Smith(mf.GGX(0.3)), mf.Masking)
    True
    """

    Lambda_kernel: Callable[..., float] = staticmethod(no_Lambda)  # Lambda(w, parameters)
    G1_kernel: Callable[..., float]  # G1(Lambda_o, om, wo, wm, parameters)
    G2_kernel: Callable[..., float]  # G2(Lambda_o, Lambda_i, om, im, wo, wi, wm, parameters)
    parameters: ModelParameters

    def __init__(self, ndf: Distribution, own: Parameters = ()) -> None:
        if not isinstance(ndf, Distribution):
            raise ValueError(f"ndf must be a distribution of normals such as GGX(0.3), got {ndf!r}")
        self.ndf = ndf
        self.parameters = ModelParameters(ndf.parameters, own)

    def G1(self, wo: ArrayLike, wm: ArrayLike) -> NDArray[Any]:
        """Masking function: the fraction of the microfacets with normal wm that is visible from wo.

        Parameters
        ----------
        wo : array_like, shape (..., 3)
            View directions, unit vectors.
        wm : array_like, shape (..., 3)
            Microfacet normals, unit vectors; shapes broadcast.

        Returns
        -------
        ndarray, shape (...)
            Fraction, in [0, 1] for a physical model; 0 below the horizon and for microfacets turned away.

        Raises
        ------
        ValueError
            If an argument does not hold unit vectors.

        References
        ----------
        heitz2014.

        Examples
        --------
        >>> import microfacet as mf
        >>> print(f"{mf.Smith(mf.GGX(0.5)).G1([0.6, 0.0, 0.8], [0, 0, 1]):.4f}")
        0.9671
        """
        kernel = G1_of_directions(self.Lambda_kernel, self.G1_of_facet)
        return over_pairs(kernel)([vectors("wo", wo), vectors("wm", wm)], self.parameters)

    def G2(self, wo: ArrayLike, wi: ArrayLike, wm: ArrayLike) -> NDArray[Any]:
        """Masking-shadowing function: the fraction of the microfacets with normal wm that is visible from both wo and wi.

        Parameters
        ----------
        wo : array_like, shape (..., 3)
            View directions, unit vectors.
        wi : array_like, shape (..., 3)
            Light directions, unit vectors.
        wm : array_like, shape (..., 3)
            Microfacet normals, unit vectors; shapes broadcast.

        Returns
        -------
        ndarray, shape (...)
            Fraction, at most that of either direction for a physical model; 0 where `G1` of either is.

        Raises
        ------
        ValueError
            If an argument does not hold unit vectors.

        References
        ----------
        heitz2014, eq. 98 (separable) and eq. 99 (height-correlated) for Smith's model.

        Examples
        --------
        >>> import microfacet as mf
        >>> print(f"{mf.Smith(mf.GGX(0.5)).G2([0.6, 0.0, 0.8], [-0.6, 0.0, 0.8], [0, 0, 1]):.4f}")
        0.9363
        """
        arrays = [vectors("wo", wo), vectors("wi", wi), vectors("wm", wm)]
        kernel = G2_of_directions(self.Lambda_kernel, self.G2_of_facet)
        return over_triples(kernel)(arrays, self.parameters)

    def D_visible(self, wo: ArrayLike, wm: ArrayLike) -> NDArray[Any]:
        r"""Distribution of visible normals, in 1/sr.

        .. math:: D_{\omega_o}(\omega_m) = \frac{G_1(\omega_o, \omega_m)
                  \left\langle \omega_o, \omega_m \right\rangle D(\omega_m)}{\cos\theta_o}

        Statement ``visibility.masking.D_visible``.

        Parameters
        ----------
        wo : array_like, shape (..., 3)
            View directions, unit vectors.
        wm : array_like, shape (..., 3)
            Microfacet normals, unit vectors; shapes broadcast.

        Returns
        -------
        ndarray, shape (...)
            Probability density over normals, 1/sr; 0 below the horizon and for microfacets turned away.

        Raises
        ------
        ValueError
            If an argument does not hold unit vectors.

        References
        ----------
        heitz2014; heitzdeon2014.

        Examples
        --------
        >>> import microfacet as mf
        >>> print(f"{mf.Smith(mf.GGX(0.5)).D_visible([0.6, 0.0, 0.8], [0, 0, 1]):.4f}")
        1.2314
        """
        kernel = visible_density(self.Lambda_kernel, self.G1_of_facet, type(self.ndf).kernel)
        return over_pairs(kernel)([vectors("wo", wo), vectors("wm", wm)], self.parameters)

    def sample_visible(self, wo: ArrayLike, u: ArrayLike, out: NDArray[Any] | None = None) -> NDArray[Any]:
        """Draw normals with density `D_visible`.

        Parameters
        ----------
        wo : array_like, shape (..., 3)
            View directions, unit vectors.
        u : array_like, shape (..., 2)
            Uniform numbers in [0, 1); shapes broadcast.
        out : ndarray, optional
            Array of the result's shape and precision to fill and return; its contents are undefined after an error.

        Returns
        -------
        ndarray, shape (..., 3)
            Unit normals; the zero vector where wo is below the horizon.

        Raises
        ------
        ValueError
            If the model has no such sampler, if wo does not hold unit vectors, or if u is outside [0, 1).

        References
        ----------
        dupuy2023 for GGX, heitzdeon2014 for Beckmann; heitz2018.

        Examples
        --------
        >>> import microfacet as mf
        >>> print(mf.Smith(mf.GGX(0.5)).sample_visible([0.6, 0.0, 0.8], [0.5, 0.25]).round(4))
        [-0.1715  0.      0.9852]
        """
        if self.sampler is None:
            raise ValueError(f"{self!r} has no sampler of visible normals; Smith over GGX or Beckmann has")
        return _sampling(self.sampler)([vectors("wo", wo), uniform("u", u)], self.parameters, out)

    @property
    def G1_of_facet(self) -> Callable[..., float]:
        """G1(Lambda_o, wo, wm, parameters); 0 at a facet turned away."""
        return G1_of_facet(self.G1_kernel)

    @property
    def G2_of_facet(self) -> Callable[..., float]:
        """G2(Lambda_o, Lambda_i, wo, wi, wm, parameters) at a facet turned to both directions."""
        return G2_of_facet(self.G2_kernel)

    @property
    def sampler(self) -> Callable[..., Vector] | None:
        """The kernel that samples visible normals, sampler(wo, u, parameters), if there is one."""
        return None

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.ndf!r})"


def dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@cache
def G1_of_facet(G1: Callable[..., float]) -> Callable[..., float]:
    """G1 of a direction and a normal, given G1 of the cosine between them."""

    def G1_of_facet(Lambda_o: float, wo: Vector, wm: Vector, p: ModelParameters) -> float:
        om = dot(wo, wm)
        return G1(Lambda_o, om, wo, wm, p) if om > 0.0 else 0.0

    return G1_of_facet


@cache
def G2_of_facet(G2: Callable[..., float]) -> Callable[..., float]:
    """G2 of two directions and a normal, given G2 of the cosines between them."""

    def G2_of_facet(Lambda_o: float, Lambda_i: float, wo: Vector, wi: Vector, wm: Vector, p: ModelParameters) -> float:
        return G2(Lambda_o, Lambda_i, dot(wo, wm), dot(wi, wm), wo, wi, wm, p)

    return G2_of_facet


@cache
def G1_of_directions(Lambda: Callable[..., float], G1: Callable[..., float]) -> Callable[..., float]:
    """G1 of any direction and any normal, with Lambda computed. G1: that of a facet."""

    def G1_of_directions(wo: Vector, wm: Vector, p: ModelParameters) -> float:
        return G1(Lambda(wo, p), wo, wm, p) if wo[2] > HORIZON else 0.0

    return G1_of_directions


@cache
def G2_of_directions(Lambda: Callable[..., float], G2: Callable[..., float]) -> Callable[..., float]:
    """The same for two directions; 0 unless both are above the surface and on the facet's outer side."""

    def G2_of_directions(wo: Vector, wi: Vector, wm: Vector, p: ModelParameters) -> float:
        value = G2(Lambda(wo, p), Lambda(wi, p), wo, wi, wm, p)
        outside = wo[2] > HORIZON and wi[2] > HORIZON and dot(wo, wm) > 0.0 and dot(wi, wm) > 0.0
        return value if outside else 0.0

    return G2_of_directions


@cache
def over_pairs(kernel: Callable[..., float]) -> Batch:
    """A kernel of two directions over arrays."""
    return Batch(kernel, [3, 3])


@cache
def over_triples(kernel: Callable[..., float]) -> Batch:
    """A kernel of three directions over arrays."""
    return Batch(kernel, [3, 3, 3])


@cache
def _sampling(kernel: Callable[..., Vector]) -> Batch:
    return Batch(kernel, [3, 2], 3)


stated_visible = visible_normals.scalar


@cache
def visible_density(
    Lambda: Callable[..., float], G1: Callable[..., float], normals: Callable[..., float]
) -> Callable[..., float]:
    """The kernel of D_visible. G1: that of a facet. normals: the kernel of D."""

    def density(wo: Vector, wm: Vector, p: ModelParameters) -> float:
        om = dot(wo, wm)
        if not (wo[2] > HORIZON and om > 0.0 and wm[2] > 0.0):
            return 0.0
        return stated_visible(G1(Lambda(wo, p), wo, wm, p), om, 1.0, wo[2]) * normals(wm, p.ndf)

    return density
