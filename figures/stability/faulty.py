"""Methods that fail, as textbooks and programs have them: exhibits, each a formula long. The library uses none.

They take arrays of either precision and stay in it. `ndf` has one roughness, alpha.
"""

import numpy as np
from scipy.special import erf, erfc

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
