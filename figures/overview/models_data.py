"""Computes what the figure `models` shows: which models in use pass the four equations, and how many of them each fails."""

import sys

import microfacet as mf
import numpy as np
from microfacet.validation.equations import validate
from report.datafile import store

ALPHA = 0.4
EQUATIONS = ("projected_area", "visible_area", "visible_norm", "weak_furnace")
MODELS = (
    ("GGX, Smith", lambda: mf.Smith(mf.GGX(ALPHA))),
    ("Beckmann, Smith", lambda: mf.Smith(mf.Beckmann(ALPHA))),
    ("GGX, V-cavities", lambda: mf.VCavity(mf.GGX(ALPHA))),
    ("Beckmann, V-cavities", lambda: mf.VCavity(mf.Beckmann(ALPHA))),
    ("stretched GGX, Smith", lambda: mf.Smith(mf.GGX(ALPHA, ALPHA / 4))),
    ("Ward, V-cavities", lambda: mf.VCavity(mf.Ward(ALPHA))),
    ("first Blinn-Phong, V-cavities", lambda: mf.VCavity(mf.BlinnPhong(2 / ALPHA**2 - 2))),
    ("normalised Blinn-Phong, V-cavities", lambda: mf.VCavity(mf.NormalizedBlinnPhong(2 / ALPHA**2 - 2))),
    ("GGX, Schlick-Smith", lambda: mf.SchlickSmith(mf.GGX(ALPHA))),
    ("GGX, Kelemen", lambda: mf.Kelemen(mf.GGX(ALPHA))),
    ("GGX, Implicit", lambda: mf.Implicit(mf.GGX(ALPHA))),
)


def compute() -> dict:
    found = [validate(make()) for _, make in MODELS]
    failed = [[verdicts[equation].verdict == "fails" for equation in EQUATIONS] for verdicts in found]
    held = [[verdicts[equation].verdict == "holds" for equation in EQUATIONS] for verdicts in found]
    if np.any(np.equal(failed, held)):
        raise SystemExit("A model of the figure `models` has a verdict that is neither yes nor no.")
    return {"name": np.array([name for name, _ in MODELS]), "failed": np.array(failed), "alpha": np.array(ALPHA)}


if __name__ == "__main__":
    store(sys.argv[1], **compute())
