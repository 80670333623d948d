"""Computes what the figure `samplers` shows: whether normals drawn from uniform numbers give these numbers back."""

import sys

import mpmath
import numpy as np
from faulty import beckmann_newton, beckmann_turned, ggx_across, ggx_cap
from microfacet.datafile import rounded, store
from microfacet.geometry.beckmann import Beckmann
from microfacet.geometry.ggx import GGX
from microfacet.statement import DIGITS
from microfacet.validation.trust import ALPHA as ALPHAS
from microfacet.validation.trust import MOST, directions
from microfacet.validation.trust import TANGENT as TANGENTS
from microfacet.validation.trust import rounded as as_seen
from microfacet.visibility.smith import Smith
from scipy.special import erfc

ALPHA, TANGENT = ALPHAS[::2], TANGENTS[::2]
ODDS = np.logspace(-7, 7, 29)  # u/(1 - u)
TURN = 0.3  # the other uniform number
THETA = np.radians([1, 20, 40, 60, 80, 89])
STEPS = np.arange(1, 9)
U = (np.arange(2000) + 0.5) / 2000
FEW = 3
mpf = mpmath.mpf


def library(ndf, wo, u):
    return Smith(ndf).sample_visible(wo, u)


def unstretched(ndf, w, power: int) -> list:
    """A direction (power 1) or a normal (-1) on the surface of unit roughness, of unit length, to 50 digits."""
    alpha = mpf(ndf.alpha_x) ** power
    x, y, z = (mpf(float(c)) for c in w)
    length = mpmath.sqrt((alpha * x) ** 2 + (alpha * y) ** 2 + z**2)
    return [alpha * x / length, alpha * y / length, z / length]


def ggx_numbers(ndf, wo, m) -> list:
    """The uniform numbers of which a normal is made: mirrored at it, the view falls on a spherical cap."""
    v, h = unstretched(ndf, wo, 1), unstretched(ndf, m, -1)
    twice = 2 * sum(a * b for a, b in zip(v, h, strict=True))
    x, y = (twice * b - a for a, b in zip(v[:2], h[:2], strict=True))
    return [mpmath.atan2(y, x) / (2 * mpmath.pi) % 1, 1 - twice * h[2] / (1 + v[2])]


def beckmann_numbers(ndf, wo, m) -> list:
    """The same for slopes along the view, by the share of what is seen, and across."""
    v, h = unstretched(ndf, wo, 1), unstretched(ndf, m, -1)
    sine = mpmath.hypot(v[0], v[1])
    x, y = -h[0] / h[2], -h[1] / h[2]
    along, across = (v[0] * x + v[1] * y) / sine, (v[0] * y - v[1] * x) / sine

    def share(q):
        return v[2] * mpmath.erfc(-q) / 2 + sine * mpmath.exp(-q * q) / (2 * mpmath.sqrt(mpmath.pi))

    return [share(along) / share(v[2] / sine), mpmath.erfc(-across) / 2]


def digits(numbers, ndf, wo, u, m) -> float:
    """Digits of the uniform numbers that a normal gives back; of the second relative to its distance from 0 or 1."""
    if not np.isfinite(m).all():
        return 0.0
    with mpmath.workdps(DIGITS):
        u1, u2 = (mpf(float(one)) for one in u)
        first, second = numbers(ndf, wo, m)
        off = float(max(abs(first - u1), abs(second - u2) / min(u2, 1 - u2)))
    return float(min(max(-np.log10(off), 0), MOST[m.dtype.type])) if off else MOST[m.dtype.type]


def over_numbers(method, real) -> np.ndarray:
    """GGX at alpha = 1, over uniform numbers (rows) and views."""
    ndf, views = GGX(1.0), directions(real, TANGENT)
    u = np.stack([np.full(len(ODDS), TURN), ODDS / (1 + ODDS)], axis=-1).astype(real)
    drawn = method(ndf, views[:, None], u[None])
    return np.array(
        [[digits(ggx_numbers, ndf, wo, u[k], m[k]) for wo, m in zip(views, drawn, strict=True)] for k in range(len(u))]
    )


def over_roughness(method, real) -> np.ndarray:
    """Beckmann at one pair of numbers, over roughness (rows) and views."""
    views, u = directions(real, TANGENT), np.array([TURN, 0.7], real)
    found = []
    for alpha in ALPHA:
        ndf = Beckmann(as_seen(alpha, real))
        drawn = method(ndf, views, np.broadcast_to(u, (len(views), 2)))
        found.append([digits(beckmann_numbers, ndf, wo, u, m) for wo, m in zip(views, drawn, strict=True)])
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
    return rounded(data, digits=3)


if __name__ == "__main__":
    store(sys.argv[1], **compute())
