"""Computes what the figure `samplers` shows: whether normals drawn from uniform numbers give these numbers back."""

import sys

import numpy as np
from faulty import beckmann_newton, beckmann_turned, ggx_across, ggx_cap
from microfacet.geometry.beckmann import Beckmann
from microfacet.geometry.ggx import GGX
from microfacet.validation.accuracy import ALPHA as ALPHAS
from microfacet.validation.accuracy import TANGENT as TANGENTS
from microfacet.validation.accuracy import directions, numbers_back
from microfacet.validation.accuracy import rounded as as_seen
from microfacet.visibility.smith import Smith
from report.datafile import rounded, store
from scipy.special import erfc

ALPHA, TANGENT = ALPHAS[::2], TANGENTS[::2]
ODDS = np.logspace(-7, 7, 29)  # u/(1 - u)
TURN = 0.3  # the other uniform number
THETA = np.radians([1, 20, 40, 60, 80, 89])
STEPS = np.arange(1, 9)
U = (np.arange(2000) + 0.5) / 2000
FEW = 3


def library(ndf, wo, u):
    return Smith(ndf).sample_visible(wo, u)


def over_numbers(method, real) -> np.ndarray:
    """GGX at alpha = 1, over uniform numbers (rows) and views."""
    ndf, views = GGX(1.0), directions(real, TANGENT)
    u = np.stack([np.full(len(ODDS), TURN), ODDS / (1 + ODDS)], axis=-1).astype(real)
    drawn = method(ndf, views[:, None], u[None])
    return np.array([[numbers_back(ndf, wo, u[k], m[k]) for wo, m in zip(views, drawn, strict=True)] for k in range(len(u))])


def over_roughness(method, real) -> np.ndarray:
    """Beckmann at one pair of numbers, over roughness (rows) and views."""
    views, u = directions(real, TANGENT), np.array([TURN, 0.7], real)
    found = []
    for alpha in ALPHA:
        ndf = Beckmann(as_seen(alpha, real))
        drawn = method(ndf, views, np.broadcast_to(u, (len(views), 2)))
        found.append([numbers_back(ndf, wo, u, m) for wo, m in zip(views, drawn, strict=True)])
    return np.array(found)


def newton_error(theta: float, steps: int, real: type) -> float:
    """The largest distance between a number and the share of what is seen below the slope found for it."""
    x = beckmann_newton(real(theta), U.astype(real), steps).astype(float)

    def share(q):
        return np.cos(theta) * erfc(-q) / 2 + np.sin(theta) * np.exp(-q * q) / (2 * np.sqrt(np.pi))

    return np.abs(share(x) / share(1 / np.tan(theta)) - U.astype(real)).max()


def library_error() -> float:
    """The same of the library's sampler, which steps until nothing moves."""
    worst = 0.0
    for theta in THETA:
        m = Smith(Beckmann(1.0)).sample_visible([np.sin(theta), 0, np.cos(theta)], np.stack([U, 0 * U + 0.5], axis=-1))
        q = -m[:, 0] / m[:, 2]
        share = [
            np.cos(theta) * erfc(-x) / 2 + np.sin(theta) * np.exp(-x * x) / (2 * np.sqrt(np.pi)) for x in (q, 1 / np.tan(theta))
        ]
        worst = max(worst, np.abs(share[0] / share[1] - U).max())
    return worst


def compute() -> dict:
    data = {
        "alpha": ALPHA,
        "tangent": TANGENT,
        "odds": ODDS,
        "steps": STEPS,
        "u": U,
        "few": FEW,
        "library_error": library_error(),
    }
    with np.errstate(all="ignore"):
        for real in (np.float64, np.float32):
            name = real.__name__
            for form, method in (("published", ggx_cap), ("library", library)):
                data[f"ggx_{form}_{name}"] = over_numbers(method, real)
            for form, method in (("published", beckmann_turned), ("library", library)):
                data[f"beckmann_{form}_{name}"] = over_roughness(method, real)
            data[f"newton_{name}"] = [max(newton_error(theta, steps, real) for theta in THETA) for steps in STEPS]
    z = ggx_across(U)
    data["across"] = np.abs(0.5 + (z / (1 + z * z) + np.arctan(z)) / np.pi - U)
    return rounded(data, digits=3) | {"u": U}  # the axis needs more digits than what is drawn over it


if __name__ == "__main__":
    store(sys.argv[1], **compute())
