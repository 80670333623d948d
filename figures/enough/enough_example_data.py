"""Computes what the figure `enough_example` shows: one choice, all its candidates, their errors and costs."""

import sys
from pathlib import Path

import microfacet as mf
import numpy as np
from microfacet.confidence import ODDS
from microfacet.enough import cost
from microfacet.enough.candidates import maskings
from microfacet.enough.choice import MEASURES, choice
from microfacet.enough.comparison import Comparison
from microfacet.enough.scene import Scene
from report.datafile import rounded, store

ALPHA, THETA, TOLERANCE = (0.05, 0.3), (0.0, 80.0), 1e-2
RECORD = Path("records/benchmarks.json")
METAL = mf.Conductor(0.2, 3.9)


def compute() -> dict:
    costs = cost.recorded(RECORD)
    comparison = Comparison(Scene(ALPHA, THETA, fresnel=METAL), walks=1 << 17)
    made = {measure: choice(comparison, measure, TOLERANCE, costs, beyond=True) for measure in MEASURES}
    example = made["picture"]
    data = example.data() | {"alpha": ALPHA, "theta": THETA, "timed": bool(np.isfinite(example.data()["cost"]).any())}
    data["failed"] = [row is example.failed for row in example.rows]
    data["maskings"] = [maskings()[row.candidate.masking][0] for row in example.rows]
    data["samplers"] = list(cost.SAMPLERS.values())
    data["squares"] = [example.samplers[name][1] for name in cost.SAMPLERS]
    data["sampling"] = [example.samplers[name][0] for name in cost.SAMPLERS]
    data["measures"] = list(made)
    data["choices"] = [one.chosen.candidate.label if one.chosen else "none" for one in made.values()]
    data["errors"] = [(one.chosen or one.rows[-1]).measured.error for one in made.values()]
    data["beyond"] = [one.beyond for one in made.values()]
    data["odds"] = ODDS
    return rounded({name: np.asarray(values) for name, values in data.items()}, digits=4)


if __name__ == "__main__":
    store(sys.argv[1], **compute())
