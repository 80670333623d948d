"""Shadowing for Smith's model: four ways in which masking and shadowing may depend on each other."""

from __future__ import annotations

import sympy as sp

from microfacet import balls
from microfacet.notation import G1, LATEX, Lambda_i, Lambda_o, phi, u
from microfacet.statement import Equation

OCCLUSION = (0, 1e4)
G1_i = sp.Symbol("G1_i", nonnegative=True)
LATEX[G1_i] = r"G_1(\omega_i, \omega_m)"
blend = sp.Symbol("lambda_", nonnegative=True)
LATEX[blend] = r"\lambda"
DEGREES_OF_CORRELATION = sp.Rational(441, 100)  # van Ginneken et al. 1998: 4.41 per radian


def stated(name: str) -> sp.Symbol:
    symbol = sp.Symbol(f"G2_{name}")
    LATEX[symbol] = r"G_2(\omega_o, \omega_i, \omega_m)"
    return symbol


with sp.evaluate(False):
    separable = Equation(
        key="brdf.shadowing.separable",
        title="masking and shadowing independent",
        symbol=stated("separable"),
        means=G1 * G1_i,
        equals=1 / ((1 + Lambda_o) * (1 + Lambda_i)),
        where={G1: 1 / (1 + Lambda_o), G1_i: 1 / (1 + Lambda_i)},
        proved_by="sympy: Smith's G1 put in for both directions",
        over={Lambda_o: OCCLUSION, Lambda_i: OCCLUSION},
        slides=(49, 50),
        cite="heitz2014, eq. 98",
    )
    height = Equation(
        key="brdf.shadowing.height",
        title="masking and shadowing correlated by the height of the facet",
        symbol=stated("height"),
        means=sp.Integral(u**Lambda_o * u**Lambda_i, (u, 0, 1)),
        equals=1 / (1 + Lambda_o + Lambda_i),
        enclosed=lambda it: balls.agreement(
            it.means, it.equals, (Lambda_o, Lambda_i), [(0.0, 0.0), (0.25, 0.5), (1.0, 3.0), (1e3, 0.1)]
        ),
        over={Lambda_o: OCCLUSION, Lambda_i: OCCLUSION},
        slides=(49, 50),
        cite="heitz2014, eq. 99",
        note="A facet at height quantile u is seen with probability u to the Lambda, whatever the distribution of heights.",
    )
    correlation = Equation(
        key="brdf.shadowing.lambda",
        title="how far apart in azimuth the two directions are",
        symbol=sp.Function("lambda")(phi),
        equals=DEGREES_OF_CORRELATION * phi / (DEGREES_OF_CORRELATION * phi + 1),
        over={phi: (0, 3.141592)},
        slides=(49, 50),
        cite="ginneken1998",
        note="Measured by van Ginneken et al.: 0 for the same azimuth, near 1 beyond a radian.",
    )
    direction = Equation(
        key="brdf.shadowing.direction",
        title="masking and shadowing correlated by direction",
        symbol=stated("direction"),
        equals=blend / ((1 + Lambda_o) * (1 + Lambda_i)) + (1 - blend) / (1 + sp.Max(Lambda_o, Lambda_i)),
        over={Lambda_o: OCCLUSION, Lambda_i: OCCLUSION, blend: (0, 1)},
        slides=(49, 50),
        cite="ashikhmin2000; heitz2014",
        note="From the smaller of both G1 where the directions agree to their product where they do not.",
    )
    height_direction = Equation(
        key="brdf.shadowing.height_direction",
        title="masking and shadowing correlated by height and direction",
        symbol=stated("height_direction"),
        equals=1 / (1 + sp.Max(Lambda_o, Lambda_i) + blend * sp.Min(Lambda_o, Lambda_i)),
        over={Lambda_o: OCCLUSION, Lambda_i: OCCLUSION, blend: (0, 1)},
        slides=(49, 50),
        cite="heitz2014",
    )
