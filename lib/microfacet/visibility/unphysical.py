"""Masking functions that no surface with the same normals has: Implicit, Kelemen, Schlick-Smith. Here to be measured."""

from __future__ import annotations

from math import pi, sqrt
from typing import Any, NamedTuple

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike

from microfacet.compiler.kernels import Vector
from microfacet.directions import positive
from microfacet.geometry import ggx
from microfacet.geometry.slopes import Distribution, alpha_of
from microfacet.parameters import double, each, together
from microfacet.statements.notation import Lambda_o, a, chi, im, mu_i, mu_o, om, printed_symbol
from microfacet.statements.statement import Equation
from microfacet.visibility.masking import Masking, ModelParameters

k = sp.Symbol("k", nonnegative=True)
COSINE = (1e-8, 1)
HALF = sp.Rational(1, 2)

with sp.evaluate(False):
    implicit_G1 = Equation(
        key="visibility.implicit.G1",
        title="Implicit masking",
        symbol=printed_symbol("G1_implicit", r"G_1(\omega_o, \omega_m)"),
        equals=chi(om) * mu_o,
        over={om: (-1, 1), mu_o: COSINE},
        slides=(58,),
        cite="hoffman2010",
    )
    implicit_G2 = Equation(
        key="visibility.implicit.G2",
        title="Implicit masking and shadowing: what makes the BRDF's denominator vanish",
        symbol=printed_symbol("G2_implicit", r"G_2(\omega_o, \omega_i, \omega_m)"),
        equals=mu_o * mu_i,
        over={mu_o: COSINE, mu_i: COSINE},
        slides=(58,),
        cite="hoffman2010",
    )
    kelemen_G1 = Equation(
        key="visibility.kelemen.G1",
        title="Kelemen masking",
        symbol=printed_symbol("G1_kelemen", r"G_1(\omega_o, \omega_m)"),
        equals=chi(om) * mu_o / om,
        over={om: (1e-6, 1), mu_o: COSINE},
        slides=(58,),
        cite="kelemen2001",
        note="Kelemen and Szirmay-Kalos state G2 only; this split in two equal factors is ours.",
    )
    kelemen_G2 = Equation(
        key="visibility.kelemen.G2",
        title="Kelemen masking and shadowing",
        symbol=printed_symbol("G2_kelemen", r"G_2(\omega_o, \omega_i, \omega_m)"),
        equals=mu_o * mu_i / (om * im),
        computed_as=mu_o / om * (mu_i / im),
        over={mu_o: COSINE, mu_i: COSINE, om: (1e-6, 1), im: (1e-6, 1)},
        slides=(58,),
        cite="kelemen2001",
        note="At the half vector both cosines are the same, and this is the square of the original.",
    )
    schlick_G1 = Equation(
        key="visibility.schlick_smith.G1",
        title="Schlick's approximation of Smith's masking",
        symbol=printed_symbol("G1_schlick", r"G_1(\omega_o, \omega_m)"),
        equals=chi(om) * mu_o / (mu_o * (1 - k) + k),
        computed_as=chi(om) * mu_o / (mu_o + k * (1 - mu_o)),
        over={om: (-1, 1), mu_o: COSINE, k: (0, 1)},
        slides=(58,),
        cite="schlick1994",
    )
    schlick_G2 = Equation(
        key="visibility.schlick_smith.G2",
        title="Schlick's approximation of Smith's masking and shadowing",
        symbol=printed_symbol("G2_schlick", r"G_2(\omega_o, \omega_i, \omega_m)"),
        equals=mu_o / (mu_o * (1 - k) + k) * mu_i / (mu_i * (1 - k) + k),
        computed_as=mu_o / (mu_o + k * (1 - mu_o)) * (mu_i / (mu_i + k * (1 - mu_i))),
        over={mu_o: COSINE, mu_i: COSINE, k: (0, 1)},
        slides=(58,),
        cite="schlick1994",
    )


def _schlick_steps(it: Equation) -> list[Any]:
    """With cot theta_o for a, GGX at alpha = 1; and Schlick's quotient at k = 1/2."""
    schlick = schlick_G1.equals.doit().subs({k: HALF, chi(om): 1})
    return [schlick - it.means, schlick - it.symbol, 1 / it.equals.subs(it.where).doit() - 1 / schlick]


with sp.evaluate(False):
    schlick_is_smith = Equation(
        key="visibility.schlick_smith.exact",
        title="Schlick's masking with k = alpha/2 is Smith's for GGX at alpha = 1",
        symbol=mu_o / (mu_o * (1 - HALF) + HALF),
        means=2 * mu_o / (1 + mu_o),
        equals=1 / (1 + Lambda_o),
        where={Lambda_o: ggx.Lambda.equals.doit().subs(a, mu_o / sp.sqrt(1 - mu_o**2))},
        proof=_schlick_steps,
        proved_by="sympy: Lambda and k put in",
        slides=(58,),
        cite="schlick1994",
    )

implicit_masking, implicit_both = implicit_G1.scalar, implicit_G2.scalar
kelemen_masking, kelemen_both = kelemen_G1.scalar, kelemen_G2.scalar
schlick_masking, schlick_both = schlick_G1.scalar, schlick_G2.scalar


def implicit_G1_kernel(Lambda_o: float, om: float, wo: Vector, wm: Vector, p: ModelParameters) -> float:
    return implicit_masking(om, wo[2])


def implicit_G2_kernel(
    Lambda_o: float, Lambda_i: float, om: float, im: float, wo: Vector, wi: Vector, wm: Vector, p: ModelParameters
) -> float:
    return implicit_both(wo[2], wi[2])


def kelemen_G1_kernel(Lambda_o: float, om: float, wo: Vector, wm: Vector, p: ModelParameters) -> float:
    return kelemen_masking(om, wo[2])


def kelemen_G2_kernel(
    Lambda_o: float, Lambda_i: float, om: float, im: float, wo: Vector, wi: Vector, wm: Vector, p: ModelParameters
) -> float:
    return kelemen_both(wo[2], wi[2], om, im)


def schlick_G1_kernel(Lambda_o: float, om: float, wo: Vector, wm: Vector, p: ModelParameters) -> float:
    return schlick_masking(om, wo[2], p.model.k)


def schlick_G2_kernel(
    Lambda_o: float, Lambda_i: float, om: float, im: float, wo: Vector, wi: Vector, wm: Vector, p: ModelParameters
) -> float:
    return schlick_both(wo[2], wi[2], p.model.k)


class Flattening(NamedTuple):
    """What Schlick's quotient has for a parameter."""

    k: float


class Implicit(Masking):
    r"""Implicit masking and shadowing, for which the BRDF is D F/4; no surface has it.

    .. math:: G_2(\omega_o, \omega_i, \omega_m) = \cos\theta_o \cos\theta_i

    Statements ``visibility.implicit.G1`` and ``visibility.implicit.G2``.

    Parameters
    ----------
    ndf : Distribution
        Distribution of normals.
    own : tuple, optional
        Parameters that a subclass adds; none here.

    Raises
    ------
    ValueError
        If ndf is not a distribution.

    References
    ----------
    hoffman2010.

    Examples
    --------
    >>> import microfacet as mf
    >>> mf.validate(mf.Implicit(mf.GGX(0.3)))["visible_area"].verdict
    'fails'
    """

    label, cite = "Implicit", "hoffman2010"

    G1_kernel = staticmethod(implicit_G1_kernel)
    G2_kernel = staticmethod(implicit_G2_kernel)


class Kelemen(Masking):
    r"""Kelemen's masking and shadowing; not of a surface with these normals.

    .. math:: G_2(\omega_o, \omega_i, \omega_m) =
              \frac{\cos\theta_o \cos\theta_i}{(\omega_o \cdot \omega_m)(\omega_i \cdot \omega_m)}

    The split into two equal factors G1 is this library's. Statements ``visibility.kelemen.G1`` and ``visibility.kelemen.G2``.

    Parameters
    ----------
    ndf : Distribution
        Distribution of normals.
    own : tuple, optional
        Parameters that a subclass adds; none here.

    Raises
    ------
    ValueError
        If ndf is not a distribution.

    References
    ----------
    kelemen2001.

    Examples
    --------
    >>> import microfacet as mf
    >>> mf.validate(mf.Kelemen(mf.GGX(0.3)))["visible_area"].verdict
    'fails'
    """

    label, cite = "Kelemen", "kelemen2001"

    G1_kernel = staticmethod(kelemen_G1_kernel)
    G2_kernel = staticmethod(kelemen_G2_kernel)


class SchlickSmith(Masking):
    r"""Schlick's rational approximation of Smith's masking; not of a surface with these normals.

    .. math:: G_1(\omega_o, \omega_m) = \frac{\chi^{+}(\omega_o \cdot \omega_m) \cos\theta_o}{(1 - k) \cos\theta_o + k}

    and G2 is the product for both directions. Statements ``visibility.schlick_smith.G1`` and ``visibility.schlick_smith.G2``.

    Parameters
    ----------
    ndf : Distribution
        Distribution of normals.
    k : array_like, optional
        Above 0; by default :math:`\alpha \sqrt{2/\pi}` with the larger roughness of ndf. Games often use :math:`\alpha/2`.

    Raises
    ------
    ValueError
        If ndf is not a distribution, if k is not above 0, or if neither k nor a roughness of ndf is known.

    References
    ----------
    schlick1994.

    Examples
    --------
    >>> import microfacet as mf
    >>> model = mf.SchlickSmith(mf.GGX(0.3), k=0.15)
    >>> print(f"{model.G1([0.6, 0.0, 0.8], [0, 0, 1]):.4f} {mf.Smith(mf.GGX(0.3)).G1([0.6, 0.0, 0.8], [0, 0, 1]):.4f}")
    0.9639 0.9877
    """

    label, cite = "Schlick-Smith", "schlick1994"

    G1_kernel = staticmethod(schlick_G1_kernel)
    G2_kernel = staticmethod(schlick_G2_kernel)

    def __init__(self, ndf: Distribution, k: ArrayLike | None = None) -> None:
        super().__init__(ndf)
        self.k = double(np.maximum(*alpha_of(ndf))) * sqrt(2 / pi) if k is None else each(positive, "k", k)
        together(ndf=ndf, k=self.k)
        self.parameters = ModelParameters(ndf.parameters, Flattening(self.k))
