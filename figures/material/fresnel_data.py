"""Computes what the figure `fresnel` shows: reflectances over angle, Schlick's error, and one ray split in two."""

import sys

import numpy as np
from microfacet.material.fresnel import Conductor, Dielectric, Schlick
from report.datafile import rounded, store

ETA = 1.5
METALS = {"$1 + 6.7\\,i$": (1.0, 6.7), "$2.9 + 3\\,i$": (2.9, 3.0)}
DEGREES = 60.0


def compute() -> dict:
    theta = np.linspace(0, 90, 361)
    cosine = np.maximum(np.cos(np.radians(theta)), 0)
    models = {"outside": Dielectric(ETA), "inside": Dielectric(1 / ETA)}
    models |= {f"metal_{k}": Conductor(*index) for k, index in enumerate(METALS.values())}
    data = {"theta": theta, "eta": ETA, "metals": list(METALS), "degrees": DEGREES}
    for name, model in models.items():
        data[name] = model.F(cosine)
        data[f"{name}_schlick"] = Schlick(float(model.F(1.0))).F(cosine)
    data["split"] = models["outside"].F(np.cos(np.radians(DEGREES)))
    data["refracted"] = np.degrees(np.arcsin(np.sin(np.radians(DEGREES)) / ETA))
    data["critical"] = np.degrees(np.arcsin(1 / ETA))
    data["brewster"] = np.degrees(np.arctan(ETA))
    return rounded(data)


if __name__ == "__main__":
    store(sys.argv[1], **compute())
