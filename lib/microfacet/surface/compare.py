"""Models compared with measured surfaces: their light in the same bins, and the distance of two lobes.

Source: heitz2014.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from microfacet.brdf.compensation import Compensated
from microfacet.brdf.microfacet import Microfacet
from microfacet.brdf.random_walk import RandomWalk
from microfacet.confidence import Estimate
from microfacet.directions import spherical
from microfacet.geometry.slopes import Distribution, alpha_of
from microfacet.surface.measure import Plan, estimate, estimate_of
from microfacet.visibility.masking import Masking
from microfacet.visibility.smith import CORRELATIONS, Smith
from microfacet.visibility.v_cavity import VCavity

Array = NDArray[np.float64]
NODES = 4  # of the rule over each bin, along either side


def models(ndf: Distribution) -> dict[str, Masking]:
    """The physical models over one distribution: V-cavities, and Smith's with each form of its G2."""
    return {"V-cavities": VCavity(ndf), **{f"Smith, {form}": Smith(ndf, form) for form in CORRELATIONS}}


def lobe_of(model: Masking, wo: ArrayLike, plan: Plan) -> Array:
    """Fraction of the light that a model of mirrors sends from wo into each of the plan's bins, shape (t, p)."""
    return binned(Microfacet(model), wo, plan)


def binned(brdf: Microfacet | Compensated, wo: ArrayLike, plan: Plan) -> Array:
    """Fraction of the light that a BRDF sends from wo into each of the plan's bins, shape (t, p)."""
    view = np.asarray(wo, float)
    azimuth = math.atan2(view[1], view[0])
    (theta, weigh_theta), (phi, weigh_phi) = (_rule(edges) for edges in plan.lobe_edges)
    wi = spherical(theta[:, None], azimuth + phi)
    light = brdf.evaluate(view, wi) * np.cos(theta[:, None]) * np.sin(theta[:, None])
    weighted = light * weigh_theta[:, None] * weigh_phi
    summed: Array = weighted.reshape(plan.bins[0], NODES, plan.bins[1], NODES).sum(axis=(1, 3))
    return summed


def walked(walk: RandomWalk, wo: ArrayLike, plan: Plan, walks: int, seed: int = 0) -> Array:
    """The same after all bounces in Smith's model, (t, p): the first by quadrature, later ones from random walks."""
    view = np.asarray(wo, float)
    wi, weight, bounces = walk.walk(view, np.random.default_rng(seed).random((walks, 2)))
    theta = np.arctan2(np.hypot(wi[:, 0], wi[:, 1]), wi[:, 2])
    phi = np.remainder(np.arctan2(wi[:, 1], wi[:, 0]) - math.atan2(view[1], view[0]) + math.pi, 2 * math.pi) - math.pi
    later = np.histogram2d(theta, phi, bins=plan.lobe_edges, weights=np.where(bounces > 1, weight, 0))[0] / walks
    return binned(walk.single, view, plan) + later


def normals_of(model: Masking, wo: ArrayLike, plan: Plan) -> Array:
    """Fraction of the view that a model gives to each of the plan's bins of slopes, shape (s, s); none beyond the outermost."""
    view, alpha = np.asarray(wo, float), alpha_of(model.ndf)
    place, weigh = _rule(plan.slope_edges)
    slopes = alpha[0] * place[:, None], alpha[1] * place
    upright = 1 / np.sqrt(1 + slopes[0] ** 2 + slopes[1] ** 2)
    wm = np.stack([-slopes[0] * upright, -slopes[1] * upright, upright], axis=-1)
    weighted = model.D_visible(view, wm) * upright**3 * alpha[0] * alpha[1] * weigh[:, None] * weigh
    binned: Array = weighted.reshape(plan.slopes, NODES, plan.slopes, NODES).sum(axis=(1, 3))
    return binned


def _rule(edges: Array) -> tuple[Array, Array]:
    """Gauss and Legendre's nodes and weights in every interval, one after the other."""
    x, w = np.polynomial.legendre.leggauss(NODES)
    half = np.diff(edges)[:, None] / 2
    return ((edges[1:] + edges[:-1])[:, None] / 2 + half * x).ravel(), (half * w).ravel()


def folded(lobe: ArrayLike) -> Array:
    """Lobes (..., t, p) averaged with their image in the plane of incidence: an isotropic surface's are even."""
    given = np.asarray(lobe, float)
    return (given + given[..., ::-1]) / 2


def coarse(lobe: ArrayLike, rows: int, columns: int) -> Array:
    """Lobes (..., t, p) with rows x columns bins of polar angle and azimuth merged into one."""
    given = np.asarray(lobe, float)
    *others, t, p = given.shape
    if t % rows or p % columns:
        raise ValueError(f"rows and columns must divide {t} and {p}, got {rows} and {columns}")
    merged: Array = given.reshape(*others, t // rows, rows, p // columns, columns).sum(axis=(-3, -1))
    return merged


def misplaced(measured: ArrayLike, light: ArrayLike) -> Estimate:
    """Misplaced light: half the sum of the differences between the mean of measured lobes (surfaces, ...) and a model's, as
    fractions of the incident light; with its standard error. Unlike `apart` it counts missing light."""
    return estimate_of(lambda lobe: 0.5 * np.abs(lobe - np.asarray(light)).sum(), measured)


def total_variation(one: ArrayLike, other: ArrayLike) -> float:
    """Half the sum of the differences of two lobes, each divided by its sum: 0 for equal shapes, 1 for disjoint ones."""
    a, b = np.asarray(one, float), np.asarray(other, float)
    return float(0.5 * np.abs(a / a.sum() - b / b.sum()).sum())


def apart(measured: ArrayLike, model: ArrayLike) -> Estimate:
    """Total variation between the mean of measured lobes (surfaces, ...) and a model's, with its standard error."""
    return estimate_of(lambda lobe: total_variation(lobe, model), measured)


def noise(measured: ArrayLike) -> float:
    """Total variation that the scatter between surfaces alone would show if the model were right."""
    lobes = np.asarray(measured, float)
    shapes = estimate(lobes / lobes.sum(axis=tuple(range(1, lobes.ndim)), keepdims=True))
    return float(0.5 * math.sqrt(2 / math.pi) * shapes.error.sum())


def in_plane(lobe: ArrayLike, solid_angle: ArrayLike) -> Array:
    """Lobes (..., t, p) over bins (t, p) in the plane of incidence: mean BRDF times cos theta_i, 1/sr, shape (..., 2 t).

    The angles run from -90 degrees, on the viewer's side, to 90; each value is the mean over two bins of azimuth, one on
    either side of the plane.
    """
    given, angles = np.asarray(lobe, float), np.asarray(solid_angle, float)
    if angles.ndim != 2 or angles.shape[1] % 2 or given.shape[-2:] != angles.shape:
        raise ValueError(f"lobe and solid_angle must have an even number p of azimuths, got {given.shape} and {angles.shape}")
    middle = angles.shape[1] // 2
    towards, away = (given[..., [k, k - 1]].sum(axis=-1) / angles[:, [k, k - 1]].sum(axis=-1) for k in (middle, 0))
    joined: Array = np.concatenate([towards[..., ::-1], away], axis=-1)
    return joined


def illuminated_fraction(model: Masking, wo: ArrayLike, wi: ArrayLike, side: int = 200, reach: float = 4.0) -> float:
    """Fraction, illuminated from wi, of the facets that are visible from wo and face wi: sums over side x side slopes up to
    reach times alpha."""
    view, light, alpha = np.asarray(wo, float), np.asarray(wi, float), alpha_of(model.ndf)
    slopes = reach * ((np.arange(side) + 0.5) * 2 / side - 1)
    x, y = np.meshgrid(alpha[0] * slopes, alpha[1] * slopes, indexing="ij")
    wm = np.stack([-x, -y, np.ones_like(x)], axis=-1) / np.sqrt(1 + x**2 + y**2)[..., None]
    wm = wm[(wm @ view > 0) & (wm @ light > 0)]
    fair = (wm @ view) * model.ndf.D(wm) * wm[:, 2] ** 3
    return float(np.sum(fair * model.G2(view, light, wm)) / np.sum(fair * model.G1(view, wm)))
