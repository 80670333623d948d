"""Computes what the figure `distributions` shows: five distributions, what they project to, and how far that is from 1."""

import sys
from typing import Any

import numpy as np
from microfacet.directions import spherical
from microfacet.families import alphas_of, of_alpha
from microfacet.geometry.slopes import Distribution
from microfacet.validation.equations import ABOVE, TOLERANCE, decide, residual
from microfacet.visibility.v_cavity import VCavity
from report.datafile import rounded, store
from report.tables import distributions

SHOWN = 0.5
FLOOR = 1e-11  # above the quadrature's error for every distribution here


def exponent(alpha: float) -> float:
    """The power of the cosine that is as rough as alpha, by the usual matching at small alpha."""
    return float(2 / alpha**2 - 2)


def as_rough(family: type[Distribution], alpha: float) -> Distribution:
    made: Any = family
    return of_alpha(family, float(alpha), float(alpha)) if alphas_of(family) else made(exponent(alpha))


def compute() -> dict:
    alpha = np.append(np.linspace(0.02, 0.8, 79), np.sqrt(1 / np.pi))
    alpha = np.sort(alpha)
    theta = np.linspace(0, np.pi / 2, 181)
    density, integral, apart, verdict = [], [], [], []
    families = distributions()
    for family in families:
        found = [residual(VCavity(as_rough(family, a)), "projected_area", ABOVE) for a in alpha]
        values, bounds = (np.array(part)[:, 0] for part in zip(*found, strict=True))
        density.append(as_rough(family, SHOWN).D(spherical(theta)))
        integral.append(1 + values)
        apart.append(np.where(np.abs(values) > FLOOR, np.abs(values), FLOOR))
        verdict.append(decide(values, bounds, TOLERANCE))
    curves = {"density": np.array(density), "integral": np.array(integral), "apart": np.array(apart)}
    axes = {"alpha": alpha, "theta": np.degrees(theta), "shown": SHOWN, "floor": FLOOR}
    return rounded({**axes, **curves, "names": [family.label for family in families], "verdict": verdict})


if __name__ == "__main__":
    store(sys.argv[1], **compute())
