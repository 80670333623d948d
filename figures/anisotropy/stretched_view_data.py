"""Computes what the figure `stretched_view` shows: rays and shares of the view, anew for each stretched surface."""

import sys

import numpy as np
from microfacet.surface.profile import Profile, angle, direction
from report.datafile import store
from report.example import example, percentages

THETA_O = np.radians(55.0)
STRETCHES = (1.0, 1.5, 2.0)
RAYS, RISE = 16, 0.15


def rays(surface: Profile, wo: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Starts over equal steps of the plane, and for each the length of its ray to the next facet, inf if it is free."""
    x = (np.arange(RAYS) + 0.5) / RAYS
    facet = np.searchsorted(surface.x, x) - 1
    start = np.stack([x, np.interp(x, surface.x, surface.z)], axis=-1)
    return start, np.array([surface.hit(k, s, wo) for k, s in zip(facet, start, strict=True)])


def state(stretch: float) -> dict:
    """The surface stretched by `stretch`, traced as a surface of its own: shrunk to unit width, which changes no angle."""
    whole, flat = example(), direction(THETA_O)
    surface = Profile(whole.x, whole.z / stretch)
    wo = np.array([stretch * flat[0], flat[1]]) / np.hypot(stretch * flat[0], flat[1])
    start, length = rays(surface, wo)
    free = np.isinf(length)
    stop = start + np.where(free, RISE / stretch / wo[1], length)[:, None] * wo
    seen = surface.visible(wo)
    share = seen.projected(wo) / wo[1]
    return {
        "x": stretch * surface.x,
        "z": stretch * surface.z,
        "ends": stretch * seen.ends,
        "middle": stretch * surface.whole.middle,
        "start": stretch * start,
        "stop": stretch * stop,
        "stopped": stop[~free, 0],
        "free": free,
        "share": share,
        "percent": percentages(share),
        "degrees": np.degrees(angle(wo)),
    }


def close(one: np.ndarray, other: np.ndarray) -> bool:
    return bool(np.allclose(one, other, rtol=0, atol=1e-12))


def compute() -> dict:
    states = [state(stretch) for stretch in STRETCHES]
    data = {name: np.stack([one[name] for one in states]) for name in states[0] if name != "stopped"}
    first = states[0]
    kept = [np.array_equal(one["free"], first["free"]) and close(one["stopped"], first["stopped"]) for one in states]
    same = [close(one["share"], first["share"]) for one in states]
    return data | {"stretch": np.array(STRETCHES), "kept": np.array(kept), "same": np.array(same)}


if __name__ == "__main__":
    store(sys.argv[1], **compute())
