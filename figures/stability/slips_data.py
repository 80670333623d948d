"""Computes what the figure `slips` shows: masking of another surface, samples of another surface, light through the surface."""

import sys

import numpy as np
from faulty import axes_swapped, frame_plain, frame_signed, one_roughness, rho_both_sides, skew
from microfacet.brdf.microfacet import Microfacet
from microfacet.directions import spherical
from microfacet.geometry.beckmann import Beckmann
from microfacet.geometry.ggx import GGX
from microfacet.validation.chi_square import p_value, p_value_of_counts
from microfacet.validation.equations import residual
from microfacet.visibility.smith import Smith
from report.datafile import rounded, store

UP, SEED = np.array([0.0, 0.0, 1.0]), 5
ROUGH, STRETCHED = GGX(0.3), GGX(0.6, 0.1)
DEGREES, HORIZON = np.arange(1.0, 90.0), np.pi / 2 - 1e-9
SAMPLES, TESTS, LEVEL = 20000, 40, 0.01
SLOPES, SHOWN = np.linspace(-2, 2, 41), 40  # in units of alpha_x; how many times SAMPLES are drawn for the picture
VIEW = spherical(np.radians(80.0))
LIGHTS = np.radians(np.arange(-89.75, 130.0, 0.5))  # polar angles on the far side from the view, beyond 90 below the horizon


def areas() -> dict:
    """Visible area over the cosine, where D and G1 belong to two surfaces; and its limit at the horizon."""
    mean = GGX(np.sqrt(STRETCHED.alpha_x * STRETCHED.alpha_y))
    slips = {
        "mean_along": (mean, STRETCHED, 0.0),
        "mean_across": (mean, STRETCHED, np.pi / 2),
        "twice": (GGX(ROUGH.alpha_x**2), ROUGH, 0.0),
        "borrowed": (Beckmann(ROUGH.alpha_x), ROUGH, 0.0),
    }
    found = {}
    for name, (other, own, azimuth) in slips.items():
        views = spherical(np.append(np.radians(DEGREES), HORIZON), azimuth)
        area = Smith(other).G1(views, UP) / Smith(own).G1(views, UP)
        found |= {name: area[:-1], f"{name}_limit": area[-1]}
    along = spherical(np.radians(DEGREES[::8]))
    off = max(np.abs(residual(Smith(ndf), "visible_area", along)[0]).max() for ndf in (ROUGH, STRETCHED))
    return found | {"right": off}


def ring_odds(normals: np.ndarray, rings: int = 24) -> float:
    """The odds of polar angles such as these, for normals seen from straight above: a test that asks for no azimuth."""
    edges = np.linspace(0, np.pi / 2, rings + 1)
    x, w = np.polynomial.legendre.leggauss(8)
    theta = (edges[:-1, None] + np.diff(edges)[:, None] * (x + 1) / 2)[..., None]
    phi = np.pi * (np.arange(256) + 0.5) / 256
    density = STRETCHED.D(spherical(theta, phi)).mean(axis=-1) * 2 * np.pi * (np.sin(theta) * np.cos(theta))[..., 0]
    share = (density * w).sum(axis=1) * np.diff(edges) / 2
    return p_value_of_counts(np.histogram(np.arccos(normals[:, 2]), edges)[0].astype(float), len(normals) * share)


def samplers() -> dict:
    """How often tests reject samples of stretched GGX, and how slopes along its rough axis are distributed."""
    methods = {"swapped": axes_swapped, "one": one_roughness, "right": lambda ndf, wo, u: Smith(ndf).sample_visible(wo, u)}
    slanted, rng, found = spherical(np.radians(60.0), 0.5), np.random.default_rng(SEED), {}
    for name, method in methods.items():
        odds = []
        for _ in range(TESTS):
            u = rng.random((2, SAMPLES, 2))
            above, normals = method(STRETCHED, UP, u[0]), method(STRETCHED, slanted, u[1])
            odds.append(
                (
                    ring_odds(above),
                    p_value(normals, lambda m: Smith(STRETCHED).D_visible(slanted, m), slanted, STRETCHED.slope_scale),
                )
            )
        found[f"rejected_{name}"] = np.mean(np.array(odds) < LEVEL, axis=0)
        m = method(STRETCHED, UP, rng.random((SHOWN * SAMPLES, 2)))
        counts = np.histogram(-m[:, 0] / m[:, 2] / STRETCHED.alpha_x, SLOPES)[0]
        found[f"density_{name}"] = counts / len(m) / np.diff(SLOPES)
    return found


def through() -> dict:
    """The lobe in the plane of incidence, times the cosine, with and without the question of sides; the share that is wrong."""
    wi = spherical(LIGHTS, np.pi)
    rough = GGX(0.5)
    lobe = {"both": rho_both_sides(rough, VIEW, wi), "sides": Microfacet(Smith(rough, "none")).evaluate(VIEW, wi)}
    x, w = np.polynomial.legendre.leggauss(96)
    turn = np.pi * (np.arange(96) + 0.5) / 96
    theta = np.pi * (x + 3) / 4  # below the horizon
    below = rho_both_sides(rough, VIEW, spherical(theta[:, None], turn)) * (np.abs(np.cos(theta)) * np.sin(theta))[:, None]
    lost = float((below.mean(axis=1) * w).sum() * np.pi / 4 * 2 * np.pi)
    found = {name: values * np.abs(np.cos(LIGHTS)) for name, values in lobe.items()}
    return found | {"through": lost / float(Microfacet(Smith(rough, "none")).albedo(VIEW))}


def frames() -> dict:
    """How far frames near -z are from right angles, and how near that is, in single precision; and mirrors seen from below."""
    tangent = np.logspace(-6, 0, 25)
    below = (spherical(np.arctan(tangent), 0.6) * [1, 1, -1]).astype(np.float32)
    found = {"frame": skew(frame_plain, below).max(), "frame_signed": skew(frame_signed, below).max()}
    brdf, numbers = Microfacet(Smith(GGX(1.0))), np.random.default_rng(SEED).random((20000, 2))
    down = [brdf.sample(wo, numbers)[:, 2] < 0 for wo in spherical(np.radians([0.0, 80.0]))]
    return found | {"frame_from": tangent[skew(frame_plain, below) > 1e-3].max(), "down": np.mean(down, axis=1)}


def compute() -> dict:
    with np.errstate(all="ignore"):
        found = {**areas(), **samplers(), **through(), **frames()}
    middles, lights = (SLOPES[1:] + SLOPES[:-1]) / 2, np.degrees(LIGHTS)
    return rounded({"degrees": DEGREES, "slopes": middles, "lights": lights, "tests": TESTS, **found}, digits=4)


if __name__ == "__main__":
    store(sys.argv[1], **compute())
