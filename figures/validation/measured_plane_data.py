"""Computes what the figure `measured_plane` shows: measured lobes and those of models in the plane of incidence."""

import sys

import numpy as np
from microfacet.geometry.beckmann import Beckmann
from microfacet.surface.compare import coarse, folded, in_plane, lobe_of
from microfacet.surface.measure import estimate
from microfacet.visibility.smith import Smith
from microfacet.visibility.v_cavity import VCavity
from report.campaign import CAMPAIGN, THETA_O, read
from report.datafile import rounded, store

ENTRIES = ("lobes_04", "lobes_07", "lobes_10")
DEGREES = (40.0, 60.0, 80.0)
ROWS = 3  # so many bins of polar angle are one here


def compute() -> dict:
    plan = CAMPAIGN[ENTRIES[0]].plan
    edges = np.degrees(plan.lobe_edges[0])[::ROWS]
    middle = (edges[1:] + edges[:-1]) / 2
    data: dict = {"theta": np.r_[-middle[::-1], middle], "degrees": DEGREES, "wedge": np.degrees(2 * np.pi / plan.bins[1])}
    data["alpha"] = [CAMPAIGN[entry].family.alpha_x for entry in ENTRIES]
    shape = (len(DEGREES), len(ENTRIES), 2 * (plan.bins[0] // ROWS))
    data |= {name: np.empty(shape) for name in ("v_cavity", "smith", "measured", "error")}
    for column, entry in enumerate(ENTRIES):
        plan, found, ndf = CAMPAIGN[entry].plan, read(entry), Beckmann(CAMPAIGN[entry].family.alpha_x)
        for row, degrees in enumerate(DEGREES):
            view = THETA_O.index(degrees)
            for name, model in (("v_cavity", VCavity(ndf)), ("smith", Smith(ndf))):
                lobe = lobe_of(model, np.asarray(plan.views)[view], plan)
                data[name][row, column] = in_plane(coarse(lobe, ROWS, 1), coarse(plan.solid_angle, ROWS, 1))
            lobes = coarse(folded(found["lobe"][:, view, 0]), ROWS, 1)
            measured = estimate(in_plane(lobes, coarse(plan.solid_angle, ROWS, 1)))
            data["measured"][row, column], data["error"][row, column] = measured
    return rounded({**data, "surfaces": len(found["surface"])}, digits=5)


if __name__ == "__main__":
    store(sys.argv[1], **compute())
