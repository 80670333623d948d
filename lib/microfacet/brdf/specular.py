"""The complete microfacet BRDF: what mirror facets, seen and lit, send from light to viewer."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, cached_property
from math import sqrt
from typing import Any, NamedTuple

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike, NDArray

from microfacet.brdf.albedo import Reflected, reflected_fraction
from microfacet.brdf.base import BRDF
from microfacet.compiler.batch import Batch
from microfacet.compiler.kernels import ByPrecision, Pair, Parameters, Vector
from microfacet.directions import as_vectors, uniform, vectors
from microfacet.geometry.slopes import drawn_from, excess_over_drawn
from microfacet.geometry.visible_normals import HORIZON
from microfacet.material.fresnel import Fresnel, Mirror
from microfacet.material.reflection import half_vector, i_vector, o_vector, reflected, weak_furnace
from microfacet.parameters import Parametric, together
from microfacet.statements import enclosures
from microfacet.statements.notation import G1, D, F, Lambda_i, Lambda_o, im, mu_i, mu_o, om, printed_symbol
from microfacet.statements.proofs import under_integral
from microfacet.statements.statement import Equation
from microfacet.visibility import shadowing, unphysical, v_cavity
from microfacet.visibility.masking import Masking, ModelParameters, dot, over_pairs
from microfacet.visibility.smith import Smith

G1_h = printed_symbol("G1_h", r"G_1(\omega_o, \omega_h)", positive=True)
G2_h = printed_symbol("G2_h", r"G_2(\omega_o, \omega_i, \omega_h)", nonnegative=True)
D_h = printed_symbol("D_h", r"D(\omega_h)", nonnegative=True)
p_i = printed_symbol("p_light", r"p_{\omega_o}(\omega_i)", nonnegative=True)
rho_io = printed_symbol("rho_io", r"\rho(\omega_i, \omega_o)")
mu = sp.Symbol("mu", positive=True)
EDGE = sp.Rational(1, 10**15)  # of a cosine, below which an integrand is bounded in place of evaluated

# --- statements ---------------------------------------------------------------------------------------------------

with sp.evaluate(False):
    complete = Equation(
        key="brdf.specular.rho",
        title="the microfacet BRDF of Cook and Torrance",
        symbol=printed_symbol("rho", r"\rho(\omega_o, \omega_i)"),
        means=F * (G2_h / G1_h) * p_i / mu_i,
        equals=F * G2_h * D_h / (4 * mu_o * mu_i),
        where={p_i: G1_h * D_h / (4 * mu_o)},
        proved_by="sympy: the density of reflected directions put in",
        over={F: (0.01, 1), G2_h: (1e-6, 1), D_h: (1e-6, 1e6), mu_o: (1e-8, 1), mu_i: (1e-8, 1)},
        slides=(21, 22, 51, 52),
        cite="cook1982; walter2007",
    )
    weight = Equation(
        key="brdf.specular.weight",
        title="what a light direction from a visible normal weighs",
        symbol=printed_symbol("weight", r"\frac{\rho(\omega_o, \omega_i) \cos\theta_i}{p_{\omega_o}(\omega_i)}"),
        equals=F * G2_h / G1_h,
        proof=lambda it: [complete.equals.doit() * mu_i / reflected.equals.doit().subs({G1: G1_h, D: D_h}) - it.equals],
        proved_by="sympy: BRDF and density put in",
        slides=(42, 51),
        cite="heitzdeon2014",
        note="Between 0 and 1: no sample weighs much more than another.",
    )
    positivity = Equation(
        key="brdf.specular.positivity",
        title="a BRDF is never negative",
        symbol=printed_symbol("rho_positive", r"\rho(\omega_o, \omega_i)"),
        equals=sp.Integer(0),
        relation=r"\ge",
        proof=lambda it: [sp.Integer(0 if complete.equals.doit().is_nonnegative else 1), it.equals],
        proved_by="sympy: every factor is nonnegative",
        slides=(24, 51),
        cite="heitz2014",
    )
    reciprocity = Equation(
        key="brdf.specular.reciprocity",
        title="light and viewer may change places",
        symbol=printed_symbol("rho_oi", r"\rho(\omega_o, \omega_i)"),
        equals=rho_io,
        proof=lambda it: [*_reciprocity_steps(), it.equals - rho_io],
        proved_by="sympy: the half vector, F and D do not change, and neither does any G2 of this report",
        slides=(24, 51),
        cite="heitz2014",
    )
    energy = Equation(
        key="brdf.specular.energy",
        title="no more light leaves than arrives",
        symbol=printed_symbol("albedo", r"\int_{\Omega} \rho(\omega_o, \omega_i) \cos \theta_i \, d\omega_i"),
        equals=sp.Integer(1),
        relation=r"\le",
        proof=lambda it: [*_energy_steps(), it.equals - weak_furnace.equals],
        proved_by="sympy: F and G2/G1 are at most 1, so that the weak white furnace is an upper bound",
        slides=(24, 51),
        cite="heitz2014",
        note="For models that pass the weak white furnace. Wrong models may meet the bound as well.",
    )
    anchor = Equation(
        key="brdf.specular.anchor",
        title="albedo of GGX at alpha = 1, height-correlated, F = 1",
        symbol=printed_symbol("E_anchor", r"E(\theta_o)"),
        means=sp.Integral(mu / (mu + mu_o), (mu, 0, 1)),
        equals=1 - mu_o * sp.log(1 + 1 / mu_o),
        enclosed=lambda it: enclosures.agreement(it.means, it.equals, (mu_o,), [(1e-6,), (0.1,), (1.0,)]),
        over={mu_o: (1e-6, 1)},
        proof=lambda: _anchor_steps(),
        proved_by="sympy: Lambda and D at alpha = 1 put in, then the antiderivative",
        slides=(73, 74, 75),
        cite="heitz2014",
        note="What single scattering loses: nothing at grazing, most at normal incidence.",
    )

    average = Equation(
        key="brdf.specular.anchor_average",
        title="the same, averaged over all light",
        symbol=printed_symbol("E_average", r"2 \int_{0}^{1} E(\theta_o) \cos\theta_o \, d\cos\theta_o"),
        means=sp.Integral(2 * mu_o * (1 - mu_o * sp.log(1 + 1 / mu_o)), (mu_o, 0, 1)),
        equals=sp.Rational(4, 3) * (1 - sp.log(2)),
        enclosed=lambda it: enclosures.agreement(_average_from(it, EDGE), it.equals, (), [()]),
        proof=lambda it: _average_steps(it),
        proved_by="sympy: the antiderivative, checked by differentiation, between its limits",
        slides=(73, 74, 75),
        cite="heitz2014",
    )


def _average_from(it: Equation, edge: sp.Expr) -> sp.Expr:
    """Below the edge the integrand lies between 0 and 2 mu."""
    (whole,) = it.means.atoms(sp.Integral)
    return under_integral(it, sp.Integral(whole.function, (mu_o, edge, 1)) + enclosures.SHARE * edge**2)


def _average_steps(it: Equation) -> list[Any]:
    logarithms = mu_o**3 * sp.log(1 + 1 / mu_o) + mu_o**2 / 2 - mu_o + sp.log(1 + mu_o)
    antiderivative = mu_o**2 - sp.Rational(2, 3) * logarithms
    ends = antiderivative.subs(mu_o, 1) - sp.limit(antiderivative, mu_o, 0, "+")
    return [sp.diff(antiderivative, mu_o) - average.means.function.doit(), sp.expand(ends - it.equals.doit())]


def _swapped(form: Any) -> sp.Expr:
    """The form with light and viewer in each other's place."""
    swap = {mu_o: mu_i, mu_i: mu_o, om: im, im: om, Lambda_o: Lambda_i, Lambda_i: Lambda_o}
    return sp.sympify(form).doit().subs(swap, simultaneous=True)


def _reciprocity_steps() -> list[Any]:
    """The BRDF, the half vector, and every form of G2 that the report states."""
    smith = [shadowing.separable, shadowing.height, shadowing.direction, shadowing.height_direction]
    others = [v_cavity.G2, unphysical.implicit_G2, unphysical.kelemen_G2, unphysical.schlick_G2]
    forms = [one.equals.doit() for one in (complete, *smith, *others)]
    half = {o_vector: i_vector, i_vector: o_vector}
    vector = half_vector.equals.doit()
    return [vector - vector.subs(half, simultaneous=True), *(form - _swapped(form) for form in forms)]


def _energy_steps() -> list[Any]:
    """What the furnace counts, less what the BRDF sends: a product of nonnegative factors, with F and G2/G1 for 1 - loss."""
    kept_F, kept_G = sp.symbols("kept_F kept_G", positive=True)
    sent = complete.equals.doit().subs({F: 1 / (1 + kept_F), G2_h: G1_h / (1 + kept_G)}) * mu_i
    excess = sp.together(reflected.equals.doit().subs({G1: G1_h, D: D_h}) - sent)
    return [sp.Integer(0 if sp.factor(excess).is_nonnegative else 1)]


def _anchor_steps() -> list[Any]:
    """At alpha = 1: 1 + Lambda_o + Lambda_i = (1/mu_o + 1/mu)/2 and D = 1/pi; the BRDF depends on the cosines only."""
    Lambda_sum = (1 / mu_o - 1) / 2 + (1 / mu - 1) / 2
    rho = 1 / (1 + Lambda_sum) / sp.pi / (4 * mu_o * mu)
    antiderivative = mu - mu_o * sp.log(mu + mu_o)
    return [
        sp.simplify(2 * sp.pi * rho * mu - mu / (mu + mu_o)),
        sp.simplify(sp.diff(antiderivative, mu) - mu / (mu + mu_o)),
        sp.expand_log(antiderivative.subs(mu, 1) - antiderivative.subs(mu, 0) - (1 - mu_o * (sp.log(1 + mu_o) - sp.log(mu_o)))),
    ]


# --- kernels --------------------------------------------------------------------------------------------------------

stated_rho, stated_density = complete.scalar, reflected.scalar
BELOW = ByPrecision(double=1 - 2.0**-52, single=1 - 2.0**-23)  # of a height: a facet on edge still lies above the plane


class BRDFParameters(NamedTuple):
    """What the kernels of a BRDF take last: the parameters of distribution, masking and reflectance."""

    ndf: Any
    model: Any
    fresnel: Any


class LobeParameters(NamedTuple):
    """The same where a distribution has all but F as one kernel, the lobe."""

    lobe: Any
    fresnel: Any


def added(wo: Vector, wi: Vector) -> tuple[Vector, float]:
    """wo + wi and its length, half of which is the cosine of both with the half vector."""
    hx, hy, hz = wo[0] + wi[0], wo[1] + wi[1], wo[2] + wi[2]
    return (hx, hy, hz), sqrt(hx * hx + hy * hy + hz * hz)


def divided(v: Vector, length: float) -> Vector:
    return v[0] / length, v[1] / length, v[2] / length


@cache
def evaluation(
    D: Callable[..., float], Lambda: Callable[..., float], G2: Callable[..., float], F: Callable[..., float]
) -> Batch:
    """The BRDF part by part; D last, since it alone may be too small for a number: then `pdf` is 0 as well."""

    def evaluate(wo: Vector, wi: Vector, p: BRDFParameters) -> float:
        h, length = added(wo, wi)
        if not (wo[2] > HORIZON and wi[2] > HORIZON and length > 0.0):
            return 0.0
        wh, cosine = divided(h, length), min(0.5 * length, 1.0)
        shadowing = G2(Lambda(wo, p), Lambda(wi, p), cosine, cosine, wo, wi, wh, p)
        return stated_rho(F(cosine, p.fresnel), shadowing, 1.0, wo[2], wi[2]) * D(wh, p.ndf)

    return over_pairs(evaluate)


@cache
def joined_evaluation(lobe: Callable[..., float], F: Callable[..., float]) -> Batch:
    """The same where a distribution has all but F as one kernel."""

    def evaluate(wo: Vector, wi: Vector, p: LobeParameters) -> float:
        hx, hy, hz = wo[0] + wi[0], wo[1] + wi[1], wo[2] + wi[2]
        square = hx * hx + hy * hy + hz * hz
        if not (wo[2] > HORIZON and wi[2] > HORIZON and square > 0.0):
            return 0.0
        return F(min(0.5 * sqrt(square), 1.0), p.fresnel) * lobe(wo, wi, p.lobe)

    return over_pairs(evaluate)


@cache
def visible_pdf(D: Callable[..., float], Lambda: Callable[..., float], G1: Callable[..., float]) -> Batch:
    """Density of mirror directions of sampled visible normals."""

    def pdf(wo: Vector, wi: Vector, p: ModelParameters) -> float:
        h, length = added(wo, wi)
        if not (wo[2] > HORIZON and h[2] > 0.0 and length > 0.0):
            return 0.0
        wh, cosine = divided(h, length), min(0.5 * length, 1.0)
        masking = G1(Lambda(wo, p), cosine, wo, wh, p)
        return stated_density(masking, 1.0, wo[2]) * D(wh, p.ndf)

    return over_pairs(pdf)


@cache
def normals_pdf(drawn: Callable[..., float]) -> Batch:
    """Density of mirror directions of normals sampled without regard to the viewer.

    Facets turned away send theirs down, to where wo + wi points down: they count too, or the density would not sum to 1.
    """

    def pdf(wo: Vector, wi: Vector, p: ModelParameters) -> float:
        h, length = added(wo, wi)
        if not (wo[2] > HORIZON and length > 0.0):
            return 0.0
        wm = divided(h, length if h[2] > 0.0 else -length)
        return drawn(wm, p.ndf) * wm[2] / (2.0 * length)

    return over_pairs(pdf)


@cache
def visible_weight(
    Lambda: Callable[..., float], G1: Callable[..., float], G2: Callable[..., float], F: Callable[..., float]
) -> Batch:
    """The BRDF times the cosine over `visible_pdf`: D and the cosines cancel."""

    def weight(wo: Vector, wi: Vector, p: BRDFParameters) -> float:
        h, length = added(wo, wi)
        if not (wo[2] > HORIZON and wi[2] > HORIZON and length > 0.0):
            return 0.0
        wh, cosine = divided(h, length), min(0.5 * length, 1.0)
        Lambda_o, Lambda_i = Lambda(wo, p), Lambda(wi, p)
        masking = G1(Lambda_o, cosine, wo, wh, p)
        return F(cosine, p.fresnel) * (G2(Lambda_o, Lambda_i, cosine, cosine, wo, wi, wh, p) / masking)

    return over_pairs(weight)


@cache
def normals_weight(
    excess: Callable[..., float], Lambda: Callable[..., float], G2: Callable[..., float], F: Callable[..., float]
) -> Batch:
    """The same for `normals_pdf`; excess: D over the distribution of the normals that are drawn."""

    def weight(wo: Vector, wi: Vector, p: BRDFParameters) -> float:
        h, length = added(wo, wi)
        if not (wo[2] > HORIZON and wi[2] > HORIZON and length > 0.0):
            return 0.0
        wh, cosine = divided(h, length), min(0.5 * length, 1.0)
        shadowing = G2(Lambda(wo, p), Lambda(wi, p), cosine, cosine, wo, wi, wh, p)
        return F(cosine, p.fresnel) * (shadowing / wo[2]) * (cosine / wh[2]) * excess(wh, p.ndf)

    return over_pairs(weight)


@cache
def visible_mirror(sampler: Callable[..., Vector]) -> Batch:
    """Mirror directions of sampled visible normals."""

    def mirror(wo: Vector, u: Pair, p: ModelParameters) -> Vector:
        if not wo[2] > HORIZON:
            return 0.0, 0.0, 0.0
        wm = sampler(wo, u, p)
        twice = 2.0 * dot(wo, wm)
        return twice * wm[0] - wo[0], twice * wm[1] - wo[1], max(twice * wm[2] - wo[2], -BELOW * wo[2])

    return Batch(mirror, [3, 2], 3)


@cache
def normals_mirror(slopes: Callable[..., Pair]) -> Batch:
    """Mirror directions of normals sampled without regard to the viewer, by their slopes."""

    def mirror(wo: Vector, u: Pair, p: ModelParameters) -> Vector:
        ox, oy, oz = wo
        if not oz > HORIZON:
            return 0.0, 0.0, 0.0
        slope_x, slope_y = slopes(u, p.ndf)
        mz = 1.0 / sqrt(1.0 + slope_x * slope_x + slope_y * slope_y)
        twice = 2.0 * (oz - ox * slope_x - oy * slope_y) * mz
        return -twice * slope_x * mz - ox, -twice * slope_y * mz - oy, twice * mz - oz

    return Batch(mirror, [3, 2], 3)


# --- the model --------------------------------------------------------------------------------------------------------


class Microfacet(Parametric, BRDF):
    r"""BRDF of mirror-like microfacets, for light that bounces once.

    .. math:: \rho(\omega_o, \omega_i) = \frac{F(\omega_o, \omega_h) \, G_2(\omega_o, \omega_i, \omega_h) \, D(\omega_h)}
              {4 \cos\theta_o \cos\theta_i}

    with the half vector :math:`\omega_h`; statement ``brdf.specular.rho``. Parameters that are arrays broadcast with the
    directions: a roughness per pixel or, with directions (..., 1, 3), an index per colour channel.

    Parameters
    ----------
    model : Masking
        Model of masking and shadowing, with its distribution of normals.
    fresnel : Fresnel, optional
        Reflectance of a microfacet; by default 1.

    Raises
    ------
    ValueError
        If an argument is of another kind, or if the shapes of their parameters do not broadcast.

    References
    ----------
    cook1982; walter2007; heitz2014.

    Examples
    --------
    >>> import microfacet as mf
    >>> brdf = mf.Microfacet(mf.Smith(mf.GGX(0.3, 0.1)), mf.Conductor(0.2, 3.9))
    >>> print(f"{brdf.evaluate([0.6, 0.0, 0.8], [-0.6, 0.0, 0.8]):.4f}")
    3.8459
    """

    parameters: BRDFParameters

    def __init__(self, model: Masking, fresnel: Fresnel | None = None) -> None:
        if not isinstance(model, Masking):
            raise ValueError(f"model must be a model of masking such as Smith(GGX(0.3)), got {model!r}")
        if not (fresnel is None or isinstance(fresnel, Fresnel)):
            raise ValueError(f"fresnel must be None, Dielectric, Conductor or Schlick, got {fresnel!r}")
        self.model, self.fresnel = together(model=model, fresnel=Mirror() if fresnel is None else fresnel)
        self.parameters = BRDFParameters(*model.parameters, self.fresnel.parameters)

    @cached_property
    def evaluation(self) -> tuple[Batch, Parameters]:
        """The loop of `evaluate`, in one fraction where the distribution has it, else part by part; and its parameters."""
        model, F = self.model, type(self.fresnel).kernel
        joined = model.ndf.smith_lobe if isinstance(model, Smith) and model.correlation == "height" else None
        if joined is None:
            return evaluation(type(model.ndf).kernel, model.Lambda_kernel, model.G2_kernel, F), self.parameters
        lobe, parameters = joined
        return joined_evaluation(lobe, F), LobeParameters(parameters, self.fresnel.parameters)

    def evaluate(self, wo: ArrayLike, wi: ArrayLike, out: NDArray[Any] | None = None) -> NDArray[Any]:
        """Value of the BRDF, in 1/sr, without the cosine of the light.

        Parameters
        ----------
        wo : array_like, shape (..., 3)
            View directions, unit vectors.
        wi : array_like, shape (..., 3)
            Light directions, unit vectors; shapes broadcast.
        out : ndarray, optional
            Array of the result's shape and precision to fill and return; its contents are undefined after an error.

        Returns
        -------
        ndarray, shape (...)
            BRDF, 1/sr; 0 if either direction is below the horizon.

        Raises
        ------
        ValueError
            If an argument does not hold unit vectors, or if out does not fit.

        Examples
        --------
        >>> import microfacet as mf
        >>> brdf = mf.Microfacet(mf.Smith(mf.GGX(0.3, 0.1)), mf.Conductor(0.2, 3.9))
        >>> print(f"{brdf.evaluate([0.6, 0.0, 0.8], [-0.6, 0.0, 0.8]):.4f}")
        3.8459
        """
        batch, parameters = self.evaluation
        return batch([vectors("wo", wo), vectors("wi", wi)], parameters, out)

    def sample(self, wo: ArrayLike, u: ArrayLike, out: NDArray[Any] | None = None) -> NDArray[Any]:
        """Draw light directions with density `pdf`.

        By visible normals where the model can sample them, otherwise by all normals. Some directions are below the
        horizon, where the BRDF is 0: they are lost and must be kept in the mean. The reflectance plays no part.

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
            Light directions, unit vectors; the zero vector where wo is below the horizon.

        Raises
        ------
        ValueError
            If neither model nor distribution has a sampler, if wo does not hold unit vectors, or if u is outside [0, 1).

        References
        ----------
        heitzdeon2014; dupuy2023.

        Examples
        --------
        >>> import microfacet as mf
        >>> brdf = mf.Microfacet(mf.Smith(mf.GGX(0.3, 0.1)), mf.Conductor(0.2, 3.9))
        >>> print(brdf.sample([0.6, 0.0, 0.8], [0.5, 0.25]).round(4))
        [-0.7848  0.      0.6197]
        """
        sampler, slopes = self.model.sampler, type(self.model.ndf).sample_kernel
        if sampler is None and slopes is None:
            raise ValueError(f"{self!r} has no sampler: the class of its distribution must name a sample_kernel")
        rule = normals_mirror(slopes) if sampler is None else visible_mirror(sampler)
        return rule([vectors("wo", wo), uniform("u", u)], self.model.parameters, out)

    def pdf(self, wo: ArrayLike, wi: ArrayLike) -> NDArray[Any]:
        r"""Density of the light directions that `sample` draws, over the whole sphere, in 1/sr.

        .. math:: p_{\omega_o}(\omega_i) = \frac{G_1(\omega_o, \omega_h) \, D(\omega_h)}{4 \cos\theta_o}

        where visible normals are sampled; statement ``material.reflection.density``. Above the horizon it is 0 where
        `evaluate` is and nowhere else, up to numbers too small for the precision and to F = 0.

        Parameters
        ----------
        wo : array_like, shape (..., 3)
            View directions, unit vectors.
        wi : array_like, shape (..., 3)
            Light directions, unit vectors; shapes broadcast.

        Returns
        -------
        ndarray, shape (...)
            Probability density, 1/sr; above 0 also for some directions below the horizon.

        Raises
        ------
        ValueError
            If an argument does not hold unit vectors.

        References
        ----------
        walter2007; heitzdeon2014.

        Examples
        --------
        >>> import microfacet as mf
        >>> brdf = mf.Microfacet(mf.Smith(mf.GGX(0.3, 0.1)), mf.Conductor(0.2, 3.9))
        >>> print(f"{brdf.pdf([0.6, 0.0, 0.8], [-0.6, 0.0, 0.8]):.4f}")
        3.2748
        """
        model, ndf = self.model, type(self.model.ndf)
        visible = model.sampler is not None
        rule = visible_pdf(ndf.kernel, model.Lambda_kernel, model.G1_kernel) if visible else normals_pdf(drawn_from(ndf))
        return rule([vectors("wo", wo), vectors("wi", wi)], model.parameters)

    def weight(self, wo: ArrayLike, wi: ArrayLike) -> NDArray[Any]:
        r"""Weight of a sample: the BRDF times the cosine of the light over `pdf`.

        .. math:: \frac{\rho(\omega_o, \omega_i) \cos\theta_i}{p_{\omega_o}(\omega_i)}
                  = \frac{F(\omega_o, \omega_h) \, G_2(\omega_o, \omega_i, \omega_h)}{G_1(\omega_o, \omega_h)}

        where visible normals are sampled, which is in [0, 1]; statement ``brdf.specular.weight``. D has cancelled, so the
        weight is right also where BRDF and density are too large or too small for numbers.

        Parameters
        ----------
        wo : array_like, shape (..., 3)
            View directions, unit vectors.
        wi : array_like, shape (..., 3)
            Light directions, unit vectors; shapes broadcast.

        Returns
        -------
        ndarray, shape (...)
            Weight, dimensionless; 0 if either direction is below the horizon.

        Raises
        ------
        ValueError
            If an argument does not hold unit vectors.

        References
        ----------
        heitzdeon2014.

        Examples
        --------
        >>> import microfacet as mf
        >>> brdf = mf.Microfacet(mf.Smith(mf.GGX(0.3, 0.1)), mf.Conductor(0.2, 3.9))
        >>> wo = [0.6, 0.0, 0.8]
        >>> print(f"{brdf.weight(wo, brdf.sample(wo, [0.5, 0.25])):.4f}")
        0.9185
        """
        model, F = self.model, type(self.fresnel).kernel
        if model.sampler is None:
            rule = normals_weight(excess_over_drawn(type(model.ndf)), model.Lambda_kernel, model.G2_kernel, F)
        else:
            rule = visible_weight(model.Lambda_kernel, model.G1_kernel, model.G2_kernel, F)
        return rule([vectors("wo", wo), vectors("wi", wi)], self.parameters)

    def albedo_with_error(self, wo: ArrayLike) -> tuple[NDArray[Any], NDArray[Any]]:
        """Directional albedo, and a bound of its error.

        By quadrature, some milliseconds for each set of parameters. The error is some 1e-9 of the albedo for
        isotropic mirrors, and larger where the integrand has kinks.

        Parameters
        ----------
        wo : array_like, shape (..., 3)
            Directions, unit vectors.

        Returns
        -------
        value : ndarray, shape (...)
            Albedo; 0 below the horizon.
        error : ndarray, shape (...)
            Bound of its error, absolute.

        Raises
        ------
        ValueError
            If wo does not hold unit vectors.

        Examples
        --------
        >>> import microfacet as mf
        >>> brdf = mf.Microfacet(mf.Smith(mf.GGX(0.3, 0.1)), mf.Conductor(0.2, 3.9))
        >>> value, error = brdf.albedo_with_error([0.6, 0.0, 0.8])
        >>> print(f"{value:.6f}", error < 1e-6)
        0.863457 True
        """
        return self._each_albedo(wo) if self.batch_shape else self.reflected(wo)

    def _each_albedo(self, wo: Any) -> tuple[np.ndarray, np.ndarray]:
        views = as_vectors("wo", wo)
        shape = np.broadcast_shapes(views.shape[:-1], self.batch_shape)
        values, errors = np.empty((2, *shape), views.dtype)
        views = np.broadcast_to(views, (*shape, 3))
        places, which = self.distinct()
        which = np.broadcast_to(which, shape).ravel()
        order = np.argsort(which, kind="stable")
        ends = np.searchsorted(which[order], np.arange(len(places) + 1))
        for place, chosen in zip(places, np.split(order, ends[1:-1]), strict=True):
            at = np.unravel_index(chosen, shape)
            values[at], errors[at] = self.at(*place).reflected(views[at])
        return values, errors

    @property
    def reflected(self) -> Reflected:
        """`albedo_with_error` as a function that is equal for equal models, of numbers for parameters."""
        self.require_numbers("an albedo by quadrature")
        return reflected_fraction(self.model, self.fresnel)

    def __repr__(self) -> str:
        return f"Microfacet({self.model!r}, {self.fresnel!r})"
