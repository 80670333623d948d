"""Methods that fail, as textbooks and programs have them: exhibits, each a formula long. The library uses none.

They take arrays of either precision and stay in it. `ndf` has one roughness, alpha.
"""

import numpy as np
from microfacet.directions import half_vector
from microfacet.geometry.beckmann import Beckmann
from microfacet.visibility.smith import Smith
from scipy.integrate import cubature
from scipy.special import erf, erfc, erfinv

SQRT_PI = float(np.sqrt(np.pi))


# --- distributions and Lambda, of directions (n, 3) -------------------------------------------------------------------


def real_alpha(ndf, w):
    """The roughness in the precision of the directions."""
    return w.dtype.type(ndf.alpha_x)


def ggx_D_cosine(ndf, m):
    """By the cosine alone, which next to the pole no longer tells angles apart."""
    alpha, cosine = real_alpha(ndf, m), m[..., 2]
    return alpha**2 / (np.pi * ((cosine * cosine) * (alpha**2 - 1) + 1) ** 2)


def beckmann_D_cosine(ndf, m):
    """By the cosine alone; tan^2 = (1 - cos^2)/cos^2."""
    alpha, cosine = real_alpha(ndf, m), m[..., 2]
    square = cosine * cosine
    return np.exp(-(1 - square) / (square * alpha**2)) / (np.pi * alpha**2 * square**2)


def reach(ndf, w):
    """alpha tan theta, from the components: this is no fault."""
    return real_alpha(ndf, w) * np.hypot(w[..., 0], w[..., 1]) / w[..., 2]


def ggx_Lambda_difference(ndf, wo):
    """The closed form as printed: a root near 1, less 1."""
    return (np.sqrt(1 + reach(ndf, wo) ** 2) - 1) / 2


def beckmann_Lambda_erf(ndf, wo):
    """The closed form as printed: erf near 1, less 1, and then near the other term."""
    a = 1 / reach(ndf, wo)
    return (erf(a) - 1) / 2 + np.exp(-a * a) / (2 * a * SQRT_PI)


def beckmann_Lambda_erfc(ndf, wo):
    """With the complement; the two terms still nearly cancel where a is large."""
    a = 1 / reach(ndf, wo)
    return np.exp(-a * a) / (2 * a * SQRT_PI) - erfc(a) / 2


def walter_G1(a):
    """Walter's rational fit of Beckmann's masking: up to 0.3 % off, and above 1 just below a = 1.6."""
    fit = (3.535 * a + 2.181 * a * a) / (1 + 2.276 * a + 2.577 * a * a)
    return np.where(a < 1.6, fit, 1.0)


def walter_Lambda(ndf, wo):
    return 1 / walter_G1(1 / reach(ndf, wo)) - 1


# --- samplers of visible normals, of views (n, 3) and uniform numbers (n, 2) ------------------------------------------


def stretched(ndf, wo):
    """The view of the stretched surface of unit roughness."""
    v = wo * np.array([1, 1, 0], wo.dtype) * real_alpha(ndf, wo) + wo * np.array([0, 0, 1], wo.dtype)
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def ggx_cap(ndf, wo, u):
    """Spherical caps as published: the height is measured from the equator, and what it has lost is added again."""
    v, angle = stretched(ndf, wo), 2 * np.pi * u[..., 0]
    z = (1 - u[..., 1]) * (1 + v[..., 2]) - v[..., 2]
    sine = np.sqrt(np.clip(1 - z * z, 0, 1))
    h = np.stack([sine * np.cos(angle), sine * np.sin(angle), z], axis=-1) + v
    h[..., :2] *= real_alpha(ndf, wo)
    return h / np.linalg.norm(h, axis=-1, keepdims=True)


def beckmann_turned(ndf, wo, u):
    """Sampled in the plane of the view, then turned by an azimuth that takes the sine from the cosine."""
    v = stretched(ndf, wo)
    sine = np.sqrt(1 - v[..., 2] ** 2)
    c, s = v[..., 0] / sine, v[..., 1] / sine
    upright = Smith(Beckmann(1.0)).sample_visible(np.stack([sine, 0 * sine, v[..., 2]], axis=-1), u)
    along, across = -upright[..., 0] / upright[..., 2], -upright[..., 1] / upright[..., 2]
    slopes = real_alpha(ndf, wo) * np.stack([c * along - s * across, s * along + c * across], axis=-1)
    m = np.concatenate([-slopes, np.ones_like(slopes[..., :1])], axis=-1)
    return m / np.linalg.norm(m, axis=-1, keepdims=True)


def beckmann_newton(theta, u, steps):
    """A slope along the view by so many of Newton's steps on the error function, from a fitted first guess; and its erf."""
    cot, tan = 1 / np.tan(theta), np.tan(theta)
    low, high = -np.ones_like(u), np.full_like(u, erf(cot))
    norm = 1 / (1 + erf(cot) + tan * np.exp(-cot * cot) / SQRT_PI)
    x = high - (1 + high) * (1 - u) ** (1 + theta * (-0.876 + theta * (0.4265 - 0.0594 * theta)))
    for _ in range(steps):
        x = np.where((x >= low) & (x <= high), x, (low + high) / 2)
        slope = erfinv(x)
        excess = norm * (1 + x + tan * np.exp(-slope * slope) / SQRT_PI) - u
        low, high = np.where(excess > 0, low, x), np.where(excess > 0, x, high)
        x = x - excess / (norm * (1 - slope * tan))
    return erfinv(x)


def ggx_across(u):
    """A slope across the view by a rational fit of the inverse, as renderers have it; in units of sqrt(1 + q^2)."""
    v = np.abs(2 * u - 1)
    above = v * (v * (v * 0.27385 - 0.73369) + 0.46341)
    return np.sign(u - 0.5) * above / (v * (v * (v * 0.093073 + 0.309420) - 1.0) + 0.597999)


# --- integrals that should be 1: the projected area of a distribution of normals ----------------------------------------


def over_angles(ndf, theta):
    """The integrand over the polar angle; the azimuth is done."""
    m = np.stack([np.sin(theta), 0 * theta, np.cos(theta)], axis=-1)
    return 2 * np.pi * np.sin(theta) * np.cos(theta) * ndf.D(m)


def midpoint(ndf, count=1024):
    """So many rings of equal width, however narrow the lobe."""
    theta = (np.arange(count) + 0.5) * np.pi / 2 / count
    return over_angles(ndf, theta).sum() * np.pi / 2 / count


def adaptive(ndf):
    """A rule in two angles that looks closer where its first points differ; it reports that it has converged."""
    ends = [0, 0], [np.pi / 2, 2 * np.pi]
    found = cubature(lambda x: over_angles(ndf, x[:, 0]) / (2 * np.pi), *ends, rule="genz-malik", rtol=1e-4)
    return float(found.estimate), float(found.error)


def truncated(ndf, reach=10.0):
    """Slopes up to a reach that seems far enough, by many Gauss-Legendre nodes after a map that finds the peak."""
    x, w = np.polynomial.legendre.leggauss(200)
    end = np.arcsinh(reach / ndf.alpha_x)
    t = end * (x + 1) / 2
    slope, stretch = ndf.alpha_x * np.sinh(t), ndf.alpha_x * np.cosh(t)
    return float(np.sum(w * end / 2 * 2 * np.pi * slope * ndf.P22(slope, 0 * slope) * stretch))


def to_a_bound(function, bound):
    """An integral from minus infinity by SciPy's cubature, whose nodes of version 1.17.1 lie on the other side."""
    found = cubature(lambda x: function(x[:, 0]), [-np.inf], [bound])
    return float(found.estimate), str(found.status)


def to_the_mirrored_bound(function, bound):
    """The remedy: the same integral, turned round."""
    return float(cubature(lambda x: function(-x[:, 0]), [-bound], [np.inf]).estimate)


# --- both cosines 0, and rays -------------------------------------------------------------------------------------------


def rho_squares_first(ndf, wo, wi):
    """GGX in one fraction, with the fourth powers of the sum's lengths, which underflow where both directions graze."""
    alpha, h = real_alpha(ndf, wo), wo + wi
    square, stretched = np.sum(h * h), np.sum((h[:2] / alpha) ** 2) + h[2] ** 2
    reach_o, reach_i = (np.hypot(alpha * np.hypot(w[0], w[1]), w[2]) for w in (wo, wi))
    return square**2 / (2 * np.pi * alpha**2 * stretched**2 * (wo[2] * reach_i + wi[2] * reach_o))


def rho_floored(ndf, wo, wi, floor=1e-3):
    """The fraction as printed, its denominator kept from 0 by a floor."""
    model, h = Smith(ndf), half_vector(wo, wi)
    return model.ndf.D(h) * model.G2(wo, wi, h) / max(4 * wo[2] * wi[2], wo.dtype.type(floor))


def distances(origins, directions, triangles):
    """How far along each ray (rows) each triangle is met; infinite where it is not. The usual test, in the given precision."""
    corner, first, second = triangles[:, 0], triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    p = np.cross(directions[:, None], second)
    scale = 1 / np.sum(first * p, axis=-1)
    offset = origins[:, None] - corner
    u = np.sum(offset * p, axis=-1) * scale
    q = np.cross(offset, first[None])
    v = np.sum(directions[:, None] * q, axis=-1) * scale
    t = np.sum(second * q, axis=-1) * scale
    return np.where((u >= 0) & (v >= 0) & (u + v <= 1), t, np.inf)


# --- slips that no rounding explains ------------------------------------------------------------------------------------


def axes_swapped(ndf, wo, u):
    """Visible normals of the surface turned by a right angle."""
    return Smith(type(ndf)(ndf.alpha_y, ndf.alpha_x)).sample_visible(wo, u)


def one_roughness(ndf, wo, u):
    """Visible normals of an isotropic surface in place of a stretched one."""
    return Smith(type(ndf)(np.sqrt(ndf.alpha_x * ndf.alpha_y))).sample_visible(wo, u)


def rho_both_sides(ndf, wo, wi):
    """The formula with absolute cosines and no question on which side directions are."""
    h = half_vector(wo, wi)
    h = h * np.sign(h[..., 2:])
    G1 = [Smith(ndf).G1(w * np.sign(w[..., 2:]), [0.0, 0.0, 1.0]) for w in (wo, wi)]
    return ndf.D(h) * G1[0] * G1[1] / (4 * np.abs(wo[..., 2] * wi[..., 2]))


def frame_plain(n):
    """Two vectors at right angles to a normal (n, 3) and each other, by a quotient that is 0/0 at -z."""
    x, y, z = n.T
    a = 1 / (1 + z)
    return np.stack([1 - a * x * x, -a * x * y, -x], axis=-1), np.stack([-a * x * y, 1 - a * y * y, -y], axis=-1)


def frame_signed(n):
    """The remedy: the sign of z decides which pole the quotient is kept away from."""
    x, y, z = n.T
    sign = np.copysign(1, z)
    a = -1 / (sign + z)
    first = np.stack([1 + sign * x * x * a, sign * x * y * a, -sign * x], axis=-1)
    return first, np.stack([x * y * a, sign + y * y * a, -y], axis=-1)


def skew(frame, n):
    """How far a frame is from three unit vectors at right angles; 1 where it is none."""
    axes = np.stack([*frame(n), n], axis=-2).astype(float)
    found = np.abs(axes @ np.swapaxes(axes, -1, -2) - np.eye(3)).max(axis=(-2, -1))
    return np.where(np.isfinite(found), np.minimum(found, 1), 1)
