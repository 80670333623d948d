"""Computes what the figure `lobes` shows: lobes and albedos of right and wrong models, and what the checks say of each."""

import sys

import numpy as np
from microfacet.brdf.microfacet import Microfacet
from microfacet.directions import spherical
from microfacet.geometry.beckmann import Beckmann
from microfacet.geometry.ggx import GGX
from microfacet.validation.equations import INTEGRALS
from microfacet.visibility.smith import Smith
from microfacet.visibility.unphysical import Implicit, Kelemen
from microfacet.visibility.v_cavity import VCavity
from report.datafile import rounded, store
from report.verdicts import CLASSIC, case_of

DEGREES = 60.0
MODELS = {
    "Smith, GGX": Smith(GGX(0.4)),
    "Smith, Beckmann": Smith(Beckmann(0.4)),
    "V-cavities, Beckmann": VCavity(Beckmann(0.4)),
    "Kelemen, Beckmann": Kelemen(Beckmann(0.4)),
    "Implicit, Beckmann": Implicit(Beckmann(0.4)),
}


def compute() -> dict:
    theta_o, theta_i = np.linspace(-90, 90, 721), np.linspace(0, 88, 89)
    wo, wi = spherical(np.radians(theta_o)), spherical(np.radians(DEGREES), np.pi)
    brdfs = [Microfacet(model) for model in MODELS.values()]
    cases = [case_of(name, model) for name, model in MODELS.items()]
    lobe = np.array([brdf.evaluate(wo, wi) * np.maximum(wo[:, 2], 0) for brdf in brdfs])
    return rounded(
        {
            "degrees": DEGREES,
            "theta_o": theta_o,
            "lobe": lobe,
            "peak": theta_o[np.argmax(lobe, axis=1)],
            "theta_i": theta_i,
            "albedo": np.array([brdf.albedo(spherical(np.radians(theta_i))) for brdf in brdfs]),
            "names": list(MODELS),
            "classic": [case.verdict(CLASSIC) for case in cases],
            "physical": [case.verdict(INTEGRALS) for case in cases],
        },
        digits=5,
    )


if __name__ == "__main__":
    store(sys.argv[1], **compute())
