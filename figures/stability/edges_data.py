"""Computes what the figure `edges` shows: directions at the horizon, vectors not of unit length, rays that start on a facet."""

import sys

import mpmath
import numpy as np
from faulty import distances, ggx_D_cosine, rho_floored, rho_squares_first
from microfacet.brdf.microfacet import Microfacet
from microfacet.directions import spherical
from microfacet.geometry.ggx import GGX
from microfacet.statements.reference import DIGITS
from microfacet.surface.height_field import HeightField
from microfacet.surface.lanes import ESCAPED
from microfacet.validation.accuracy import digits, exact_D, exact_Lambda
from microfacet.validation.accuracy import rounded as as_seen
from microfacet.visibility.smith import Smith
from report.datafile import rounded, store

SINGLE = np.float32
ROUGH = 0.3
COSINE = np.logspace(-18, 0, 37)[:-1]
ALPHA = np.logspace(-5, 0, 41)
LONGER = 1e-6  # by this share than a unit vector
SIZE, RAYS, SHIFTS, SEED = 16, 400, (0.0, 1e3, 1e6), 5  # cells of a relief; how far it is from the origin, in cells
OFFSETS = np.logspace(-8, 1, 37)


def exact_rho(ndf, wo, wi) -> mpmath.mpf:
    with mpmath.workdps(DIGITS):
        o, i = ([mpmath.mpf(float(c)) for c in w] for w in (wo, wi))
        h = [a + b for a, b in zip(o, i, strict=True)]
        length = mpmath.sqrt(sum(c * c for c in h))
        D = exact_D(ndf, [c / length for c in h])
        return D / (1 + exact_Lambda(ndf, wo) + exact_Lambda(ndf, wi)) / (4 * o[2] * i[2])


def grazing() -> dict:
    """Right digits of the BRDF of GGX in single precision, both directions at the same small cosine, on opposite sides."""
    brdf, seen = Microfacet(Smith(GGX(ROUGH))), GGX(as_seen(ROUGH, SINGLE))
    forms = {"squares": rho_squares_first, "floor": rho_floored, "library": lambda ndf, wo, wi: brdf.evaluate(wo, wi)}
    sine = np.sqrt(1 - COSINE**2)
    views = np.stack([sine, 0 * sine, COSINE], axis=-1).astype(SINGLE)
    pairs = [(wo, wo * np.array([-1, 1, 1], SINGLE)) for wo in views]
    exact = [exact_rho(seen, *pair) for pair in pairs]
    return {name: digits(np.array([form(GGX(ROUGH), *pair) for pair in pairs]), exact, SINGLE) for name, form in forms.items()}


def longer() -> dict:
    """Relative errors of D at the slope alpha, in double precision, if the normal is a little too long."""
    errors = {"cosine": [], "components": []}
    for alpha in ALPHA:
        m = spherical([np.arctan(alpha)], 0.6)
        for name, method in (("cosine", ggx_D_cosine), ("components", lambda ndf, m: ndf.D(m))):
            errors[name].append(abs(method(GGX(alpha), (1 + LONGER) * m) / GGX(alpha).D(m) - 1)[0])
    return errors


def relief() -> tuple[np.ndarray, np.ndarray]:
    """Heights of one tile, and the triangles of three by three, those of the middle tile first."""
    frequency = np.hypot(*np.meshgrid(np.fft.fftfreq(SIZE), np.fft.fftfreq(SIZE)))
    noise = np.fft.fft2(np.random.default_rng(SEED).normal(size=(SIZE, SIZE)))
    heights = np.fft.ifft2(noise * np.exp(-((4 * frequency) ** 2))).real
    heights = (0.7 * heights / heights.std()).astype(SINGLE)
    place = np.indices((SIZE, SIZE)).reshape(2, -1).T
    corners = np.array([[(0, 0), (1, 0), (1, 1)], [(0, 0), (1, 1), (0, 1)]])
    nodes = (place[:, None, None] + corners).reshape(-1, 3, 2)
    z = heights[nodes[..., 0] % SIZE, nodes[..., 1] % SIZE]
    tiles = sorted(((x, y) for x in (-1, 0, 1) for y in (-1, 0, 1)), key=lambda tile: tile != (0, 0))
    return heights, np.concatenate([np.concatenate([nodes + SIZE * np.array(t), z[..., None]], axis=-1) for t in tiles])


def rays() -> dict:
    """Shares of rays whose answer is wrong: by an offset, over its length, and by the library's walk."""
    heights, triangles = relief()
    rng = np.random.default_rng(SEED)
    facet = rng.integers(0, 2 * SIZE**2, RAYS)
    share = rng.dirichlet([2, 2, 2], RAYS)
    origins = np.sum(share[..., None] * triangles[facet], axis=1)
    ways = spherical(np.radians(rng.uniform(45, 78, RAYS)), rng.uniform(0, 2 * np.pi, RAYS))
    edges = np.diff(triangles[facet], axis=1)
    outside = np.sum(np.cross(edges[:, 0], edges[:, 1]) * ways, axis=-1) > 0
    origins, ways, facet = origins[outside], ways[outside], facet[outside]
    true = distances(origins, ways, triangles)
    true[np.arange(len(facet)), facet] = np.inf
    blocked = np.any((true > 0) & np.isfinite(true), axis=1)
    wrong = []
    for shift in SHIFTS:
        moved = np.array([shift, shift, 0])
        t = distances(*((a + b).astype(SINGLE) for a, b in ((origins, moved), (ways, 0), (triangles, moved))))
        wrong.append([np.mean(np.any((t > offset) & np.isfinite(t), axis=1) != blocked) for offset in OFFSETS])
    walked = HeightField(heights).trace(origins, ways, facet).facet != ESCAPED
    return {"wrong": np.array(wrong), "library": np.mean(walked != blocked), "blocked": blocked.mean(), "rays": len(facet)}


def compute() -> dict:
    with np.errstate(all="ignore"):
        data = {**grazing(), **longer()}
    names = {"cosines": COSINE, "alpha": ALPHA, "longer": LONGER, "offsets": OFFSETS, "shifts": SHIFTS}
    found = rays()
    return rounded({**data, **names, **{f"rays_{name}": values for name, values in found.items()}}, digits=4)


if __name__ == "__main__":
    store(sys.argv[1], **compute())
