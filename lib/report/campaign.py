"""The campaign: the surfaces and views that the report measures, and the files of the results.

Each entry of `CAMPAIGN` is a family of surfaces and a measurement plan for each of them. The build measures ranges of
surfaces in separate processes (shards) and gathers them; `read` returns the gathered arrays.
The build sets the number of surfaces: surface k does not depend on it.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from microfacet.directions import spherical
from microfacet.surface.gaussian import GaussianField
from microfacet.surface.measure import Measurement, Plan

from report.datafile import load

ALPHAS = {"04": 0.4, "07": 0.7, "10": 1.0}
THETA_O = (0.0, 20.0, 40.0, 60.0, 70.0, 80.0)  # degrees
LIGHT_THETAS = (60.0, 75.0)  # polar angles of the light, degrees, for the entries `azimuths`
GABOR_THETA_O = (0.0, 60.0, 80.0)
LIGHT_AZIMUTHS = (0.0, 5.0, 10.0, 20.0, 40.0, 60.0, 90.0, 135.0, 180.0)  # of the light relative to the view, degrees
STRETCHED = (0.8, 0.3)
STRETCHED_VIEWS = tuple((theta, phi) for theta in (40.0, 60.0, 80.0) for phi in (0.0, 45.0, 90.0))
GOLDEN_ANGLE = 137.50776405003785  # degrees: azimuths k * GOLDEN_ANGLE spread evenly, so that no view lies along the grid


@dataclass(frozen=True, eq=False)
class Entry:
    """A family of surfaces and the measurement plan for each."""

    family: GaussianField
    plan: Plan


def _lobes(alpha: float, root: int) -> Entry:
    views = spherical(np.radians(THETA_O), np.radians(GOLDEN_ANGLE * np.arange(1, len(THETA_O) + 1)))
    return Entry(GaussianField(512, alpha, root=root), Plan(views, side=192, bounces=6, bins=(45, 48)))


def _azimuths(alpha: float, root: int) -> Entry:
    lights = tuple(np.radians(LIGHT_THETAS)), tuple(np.radians(LIGHT_AZIMUTHS))
    return Entry(
        GaussianField(512, alpha, root=root), Plan([spherical(np.radians(60.0), 0.3)], side=192, lights=lights, bounces=0)
    )


def _stretched(root: int) -> Entry:
    views = spherical(*np.radians(STRETCHED_VIEWS).T)
    return Entry(GaussianField(512, *STRETCHED, root=root), Plan(views, side=128, bounces=6, bins=(45, 48)))


def _gabor(alpha: float, root: int) -> Entry:
    """Surfaces made by the other method, which is slower: they are smaller and viewed from fewer angles."""
    views = spherical(np.radians(GABOR_THETA_O), np.radians(GOLDEN_ANGLE * np.arange(1, 1 + len(GABOR_THETA_O))))
    return Entry(GaussianField(256, alpha, root=root), Plan(views, side=128, bounces=6, bins=(45, 48), method="gabor"))


CAMPAIGN = {
    **{f"lobes_{name}": _lobes(alpha, 1 + k) for k, (name, alpha) in enumerate(ALPHAS.items())},
    **{f"azimuths_{name}": _azimuths(alpha, 1 + k) for k, (name, alpha) in enumerate(ALPHAS.items())},
    "stretched": _stretched(4),
    "gabor_07": _gabor(0.7, 5),
}


def folder() -> Path:
    """Where the gathered results are: $MICROFACET_CAMPAIGN, else the build's folder below the current one."""
    return Path(os.environ.get("MICROFACET_CAMPAIGN", "build/campaign"))


def read(name: str) -> Measurement:
    """The gathered results of the entry of that name; if they are missing or torn, one sentence ends the program."""
    if name not in CAMPAIGN:
        raise ValueError(f"name must be one of {', '.join(CAMPAIGN)}, got {name!r}")
    return load(str(folder() / f"{name}.npz"), made_in="build/campaign")
