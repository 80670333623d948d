"""Computes what the figure `integrals` shows: integrals that miss, a density that is not one, and a test that cannot see."""

import sys

import numpy as np
from faulty import adaptive, midpoint, to_a_bound, to_the_mirrored_bound, truncated, walter_G1
from microfacet.directions import spherical
from microfacet.geometry.beckmann import Beckmann
from microfacet.geometry.ggx import GGX
from microfacet.validation.equations import residual
from microfacet.visibility.smith import Smith
from report.datafile import rounded, store
from scipy.special import erfc
from scipy.stats import chi2, ncx2

ALPHA = np.logspace(-4, 0, 25)
UP = [[0.0, 0.0, 1.0]]
FLOOR = 1e-16
THETA = np.linspace(0.5, 89.5, 90)
ROUGH = 0.3  # of the density that is not one
NARROW, GRAZING = 0.05, 85.0  # of the chi-square tests
CELLS = (20, 40)  # over polar angle and azimuth of the normal
SAMPLES = np.logspace(4, 8, 41)
LEVEL, LEAST, REPEATS = (
    0.01,
    5.0,
    200,
)  # of a chi-square test: its level, the fewest expected in a cell; and how often it is made
SEED = 8


def missed() -> dict:
    """Errors of the projected area over roughness, rule by rule."""
    found = {
        "midpoint_beckmann": [midpoint(Beckmann(a)) for a in ALPHA],
        "midpoint_ggx": [midpoint(GGX(a)) for a in ALPHA],
        "adaptive": [adaptive(Beckmann(a))[0] for a in ALPHA],
        "truncated": [truncated(GGX(a)) for a in ALPHA],
        "library_beckmann": [1 + residual(Smith(Beckmann(a)), "visible_area", UP)[0][0] for a in ALPHA],
        "library_ggx": [1 + residual(Smith(GGX(a)), "visible_area", UP)[0][0] for a in ALPHA],
    }
    return {name: np.maximum(np.abs(np.array(values) - 1), FLOOR) for name, values in found.items()}


def density_sum() -> np.ndarray:
    """What the density of visible normals sums to with Walter's masking in place of Smith's: their quotient."""
    a = 1 / (ROUGH * np.tan(np.radians(THETA)))
    return walter_G1(a) / Smith(Beckmann(ROUGH)).G1(spherical(np.radians(THETA)), UP[0])


def shares(nodes: int) -> np.ndarray:
    """The integral of the density of visible normals over each cell, by so many Gauss-Legendre nodes along each axis."""
    x, w = np.polynomial.legendre.leggauss(nodes)
    axes, weights = [], []
    for count, end in zip(CELLS, (np.pi / 2, 2 * np.pi), strict=True):
        width = end / count
        axes.append((width * (np.arange(count)[:, None] + (x + 1) / 2)).ravel())
        weights.append(np.tile(w * width / 2, count))
    theta, phi = np.meshgrid(*axes, indexing="ij")
    density = Smith(Beckmann(NARROW)).D_visible(spherical(np.radians(GRAZING)), spherical(theta, phi))
    values = density * np.sin(theta) * np.outer(*weights)
    return values.reshape(CELLS[0], nodes, CELLS[1], nodes).sum(axis=(1, 3)).ravel()


def pooled(expected: np.ndarray, *others: np.ndarray) -> list[np.ndarray]:
    """Cells that expect few are taken together; the same cells of the others."""
    few = expected < LEAST
    return [np.append(one[~few], one[few].sum()) if few.any() else one for one in (expected, *others)]


def power(true: np.ndarray, claimed: np.ndarray, samples: float) -> float:
    """The chance that a chi-square test rejects the claimed shares of cells where the true ones are others."""
    expected, right = pooled(samples * claimed, samples * true)
    expected, freedom = np.maximum(expected, 1e-3), len(expected)
    return float(ncx2.sf(chi2.isf(LEVEL, freedom), freedom, np.sum((right - expected) ** 2 / expected)))


def rejected(true: np.ndarray, claimed: np.ndarray, samples: float, rng: np.random.Generator) -> float:
    """The same by making the test many times."""
    counts = rng.multinomial(int(samples), true / true.sum(), size=REPEATS)
    expected, *drawn = pooled(samples * claimed, *counts)
    statistic = np.sum((np.array(drawn) - expected) ** 2 / expected, axis=1)
    return float(np.mean(statistic > chi2.isf(LEVEL, len(expected))))


def tests() -> dict:
    true, rng = shares(32), np.random.default_rng(SEED)
    off = 1 - float(density_sum().min())
    claims = {"walter": true * (1 - off), "coarse": shares(4), "right": true}
    data = {f"power_{name}": [power(true, claim, n) for n in SAMPLES] for name, claim in claims.items()}
    data |= {f"made_{name}": [rejected(true, claim, n, rng) for n in SAMPLES[::5]] for name, claim in claims.items()}
    data["seen_from"] = SAMPLES[np.argmax(np.array(data["power_walter"]) > 0.5)]
    return data | {"samples": SAMPLES, "off": off, "sum_true": true.sum(), "sum_coarse": claims["coarse"].sum()}


def compute() -> dict:
    estimate, error = adaptive(Beckmann(1e-3))
    half, half_error = adaptive(Beckmann(3e-3))
    reflected, status = to_a_bound(lambda x: np.exp(-((x - 1) ** 2)), 0.5)
    mirrored = to_the_mirrored_bound(lambda x: np.exp(-((x - 1) ** 2)), 0.5)
    kept = {"estimate": estimate, "error": error, "half": half, "half_error": half_error}
    exact = np.sqrt(np.pi) / 2 * erfc(0.5)
    kept |= {"reflected_error": abs(reflected - exact), "mirrored_error": abs(mirrored - exact)}
    kept |= {"reflected": reflected, "mirrored": mirrored, "status": status, "theta": THETA, "density_sum": density_sum()}
    return rounded({"alpha": ALPHA, **missed(), **kept, **tests()}, digits=5)


if __name__ == "__main__":
    store(sys.argv[1], **compute())
