"""Matt facets: each scatters evenly what it gets, and the rough surface does not."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from math import atan, atan2, cos, pi, sin, sqrt, tan
from typing import Any

import numpy as np
import sympy as sp

from microfacet.directions import as_vectors, positive, spherical, vectors
from microfacet.geometry.slopes import P22_at_m, normals_from_slopes, normals_integral, solid_angle
from microfacet.kernels import Batch
from microfacet.model import Model
from microfacet.notation import G1, G2, P22, chi, mu_i, mu_o, phi, phi_i, raw, theta_i, theta_o, wm, x, y
from microfacet.statement import Equation
from microfacet.visibility.masking import Masking, over_pairs

# --- statements -------------------------------------------------------------------------------------------------------

shown_o, shown_i = raw("shown_o", "v_o", nonnegative=True), raw("shown_i", "v_i", nonnegative=True)
over_normals = normals_integral(
    r"\left\langle \omega_o, \omega_m \right\rangle \left\langle \omega_i, \omega_m \right\rangle"
    r" G_2(\omega_o, \omega_i, \omega_m) D(\omega_m)"
)
sigma = sp.Symbol("sigma", positive=True)
matt = raw("rho_matt", r"\rho(\omega_o, \omega_i)")
lit = raw("light_of_a_facet", r"\int_{\Omega} \frac{1}{\pi} \left\langle \omega_i, \omega_m \right\rangle \, d\omega_i")


def _slope_steps(it: Equation) -> list[Any]:
    """Of each product of directions comes a cosine of the facet and one of the plane: with D and solid angle, one is left."""
    density = normals_from_slopes.equals.doit().subs(chi(sp.cos(wm.theta)), 1)
    cosine = sp.cos(wm.theta)
    inside = (shown_o * mu_o * cosine) * (shown_i * mu_i * cosine) * G2 * density * solid_angle.equals / (sp.pi * mu_o * mu_i)
    (whole,) = it.equals.atoms(sp.Integral)
    prefactors = it.equals.xreplace({whole: 1}) * whole.function.subs(P22(x, y), P22_at_m)
    return [inside - prefactors, it.means - over_normals / (sp.pi * mu_o * mu_i)]


def _furnace_steps(it: Equation) -> list[Any]:
    """A facet sends on what it gets; with G2 at most G1, what it is seen of bounds the sum, and that is the second equation."""
    seen, kept = sp.symbols("seen kept", positive=True)
    gone = G1 * seen - (G1 / (1 + kept)) * seen
    return [sp.Integer(0 if sp.factor(gone).is_nonnegative else 1), it.equals - lambert.equals]


def _ring(rho: Any) -> sp.Expr:
    """What comes from all azimuths at one angle to the facet's normal: rho times the cosine, per angle."""
    return sp.integrate(rho * sp.cos(theta_i) * sp.sin(theta_i), (phi_i, 0, 2 * sp.pi))


with sp.evaluate(False):
    rho = Equation(
        key="brdf.diffuse.rho",
        title="the BRDF of matt facets",
        symbol=matt,
        means=over_normals / (sp.pi * mu_o * mu_i),
        equals=sp.Integral(G2 * shown_o * shown_i * sp.cos(wm.theta) * P22(x, y), (x, -sp.oo, sp.oo), (y, -sp.oo, sp.oo))
        / sp.pi,
        proof=_slope_steps,
        proved_by="sympy: the integrand in slopes",
        slides=(20,),
        cite="oren1994; heitz2014",
        note="v_o is 1 - (x_o x + y_o y)/z_o where that is positive, otherwise 0; v_i likewise. Facets keep no light.",
    )
    flat = Equation(
        key="brdf.diffuse.flat",
        title="without roughness matt facets are a matt plane",
        symbol=raw("rho_flat", r"\lim_{\alpha \to 0} \rho(\omega_o, \omega_i)"),
        equals=1 / sp.pi,
        proof=lambda it: _flat_steps(it),
        proved_by="sympy: the integrand at slope 0, where nothing is hidden",
        slides=(20,),
        cite="oren1994",
    )
    lambert = Equation(
        key="brdf.diffuse.lambert",
        title="a matt facet sends on all that it gets",
        symbol=lit,
        means=sp.Integral(2 * sp.cos(theta_i) * sp.sin(theta_i), (theta_i, 0, sp.pi / 2)),
        equals=sp.Integer(1),
        proof=lambda it: [_ring(1 / sp.pi) - it.means.function.doit(), it.means.doit() - it.equals],
        proved_by="sympy: the BRDF of a matt facet is 1/pi in every direction; then the integral",
        slides=(20,),
        cite="oren1994",
    )
    energy = Equation(
        key="brdf.diffuse.energy",
        title="no more light leaves matt facets than arrives",
        symbol=raw("matt_albedo", r"\int_{\Omega} \rho(\omega_o, \omega_i) \cos \theta_i \, d\omega_i"),
        equals=sp.Integer(1),
        relation=r"\le",
        proof=_furnace_steps,
        proved_by="sympy: G2 is at most G1, and what is visible fills the view",
        slides=(20, 24, 51),
        cite="heitz2014",
    )
    oren_nayar = Equation(
        key="brdf.diffuse.oren_nayar",
        title="Oren and Nayar's fit for matt V-cavities",
        symbol=matt,
        equals=(
            1
            - sigma**2 / (2 * (sigma**2 + sp.Rational(33, 100)))
            + sp.Rational(45, 100)
            * sigma**2
            / (sigma**2 + sp.Rational(9, 100))
            * sp.Max(0, sp.cos(phi))
            * sp.sin(sp.Max(theta_o, theta_i))
            * sp.tan(sp.Min(theta_o, theta_i))
        )
        / sp.pi,
        relation=r"\approx",
        proof=lambda it: _fit_steps(it),
        proved_by="sympy: the same with both quotients divided out",
        over={theta_o: (0.001, 1.5), theta_i: (0.001, 1.5), phi: (0, 1.5), sigma: (0.001, 1)},
        slides=(20,),
        cite="oren1994",
        note="sigma is the standard deviation of the facets' angle, phi the difference of the azimuths.",
    )


def _flat_steps(it: Equation) -> list[Any]:
    (whole,) = rho.equals.atoms(sp.Integral)
    level = {shown_o: 1, shown_i: 1, G2: 1, P22(x, y): 1, sp.cos(wm.theta): 1}
    return [it.equals - rho.equals.xreplace({whole: 1}).doit() * whole.function.subs(level)]


def _fit_steps(it: Equation) -> list[Any]:
    """Two numbers that depend on sigma, once more: the one falls from 1 to 1/2, the other rises from 0 to 0.45."""
    level = (1 + sp.Rational(33, 100) / (sigma**2 + sp.Rational(33, 100))) / 2
    rise = sp.Rational(45, 100) * (1 - sp.Rational(9, 100) / (sigma**2 + sp.Rational(9, 100)))
    turn, steep, flat_ = sp.symbols("turn steep flat", positive=True)
    put = {sp.Max(0, sp.cos(phi)): turn, sp.sin(sp.Max(theta_o, theta_i)): steep, sp.tan(sp.Min(theta_o, theta_i)): flat_}
    return [it.equals.subs(put) - (level + rise * turn * steep * flat_) / sp.pi]


# --- kernels ----------------------------------------------------------------------------------------------------------

ROUNDING = 1e-13  # of a sum of some 10^4 terms
ULPS = 8  # of such a sum, or of 1 if that is larger: in single precision some 4 were seen


def rounding(sums: Any) -> Any:
    """How far sums of some 10^4 terms may be off by rounding in the precision that they have."""
    return np.maximum(ROUNDING, ULPS * float(np.finfo(sums.dtype).eps) * np.maximum(1, abs(sums)))


SAFETY = 100.0  # of the differences of rules: among random cases the truth then is within
FINE = (20, 32)  # nodes on each arc, and on each piece of a ray
COARSER = ((14, 24), (17, 28))  # two, since one may agree by chance


def gauss(count: int) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Nodes and weights on (0, 1)."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return tuple(map(float, (nodes + 1) / 2)), tuple(map(float, weights / 2))


def half_turn(angle: float) -> float:
    """The angle of the same line in [0, pi)."""
    turned = angle % pi
    return turned if turned < pi else 0.0


@cache
def ray_rule(normals: Callable[..., float], shadowed: Callable[..., float], count: int) -> Callable[..., float]:
    """The part of the integral on one ray, which is seen, and lit, up to a known point.

    V-cavities have further kinks where a slope is as steep the other way: the ray is taken in three pieces.
    """
    NODES, WEIGHTS = gauss(count)

    def along(
        angle: float,
        seen: float,
        lit: float,
        ox: float,
        oy: float,
        oz: float,
        ix: float,
        iy: float,
        iz: float,
        p: Any,
    ) -> float:
        """One ray, in the three pieces between its kinks, by its length's angle."""
        dx, dy = p[1][0] * cos(angle), p[1][1] * sin(angle)
        lean_o, lean_i = (dx * ox + dy * oy) / oz, (dx * ix + dy * iy) / iz
        first = atan2(1.0, max(abs(lean_o), abs(lean_i)))
        second = atan2(1.0, min(abs(lean_o), abs(lean_i)))
        last = min(atan2(1.0, max(max(lean_o, lean_i), 0.0)), atan(p[2]))
        total = 0.0
        for piece in range(3):
            start = 0.0 if piece == 0 else min(first if piece == 1 else second, last)
            stop = last if piece == 2 else min(first if piece == 0 else second, last)
            for k in range(count):
                w = start + (stop - start) * NODES[k]
                radius = tan(w)
                x, y = radius * dx, radius * dy
                shown, shone = 1.0 - radius * lean_o, 1.0 - radius * lean_i
                if shown > 0.0 and shone > 0.0:
                    mz = 1.0 / sqrt(1.0 + x * x + y * y)
                    mx, my = -x * mz, -y * mz
                    both = shadowed(seen, lit, ox, oy, oz, ix, iy, iz, mx, my, mz, p[0])
                    density = normals(mx, my, mz, p[0][0]) * ((mz * mz) * (mz * mz))
                    spread = radius * (1.0 + radius * radius) * (stop - start)
                    total += WEIGHTS[k] * spread * both * shown * shone * mz * density
        return total

    return along


@cache
def matt_rule(
    normals: Callable[..., float], view: Callable[..., float], shadowed: Callable[..., float], counts: tuple[int, int]
) -> Callable[..., float]:
    """The integral over unstretched slopes in polar coordinates, around the facet that lies level.

    Where two of a ray's kinks change order, and where one leaves the ray, an arc ends. Parameters: the model's, scales, reach.
    """
    count = counts[0]
    along, (NODES, WEIGHTS) = ray_rule(normals, shadowed, counts[1]), gauss(count)

    def matt(ox: float, oy: float, oz: float, ix: float, iy: float, iz: float, p: Any) -> float:
        if not (oz > 0.0 and iz > 0.0):
            return 0.0
        seen, lit = view(ox, oy, oz, p[0]), view(ix, iy, iz, p[0])
        alpha_x, alpha_y = p[1]
        a, b, c, d = alpha_x * ox / oz, alpha_y * oy / oz, alpha_x * ix / iz, alpha_y * iy / iz
        e1, e2 = half_turn(atan2(a, -b)), half_turn(atan2(c, -d))
        e3, e4 = half_turn(atan2(a - c, d - b)), half_turn(atan2(a + c, -b - d))
        low, high, left, right = min(e1, e2), max(e1, e2), min(e3, e4), max(e3, e4)
        inner, outer = max(low, left), min(high, right)
        ends_0, ends_1, ends_2, ends_3 = min(low, left), min(inner, outer), max(inner, outer), max(high, right)
        total = 0.0
        for arc in range(8):
            turn = pi if arc >= 4 else 0.0
            part = arc % 4
            start = ends_0 if part == 0 else (ends_1 if part == 1 else (ends_2 if part == 2 else ends_3))
            stop = ends_1 if part == 0 else (ends_2 if part == 1 else (ends_3 if part == 2 else ends_0 + pi))
            for k in range(count):
                angle = turn + start + (stop - start) * NODES[k]
                total += WEIGHTS[k] * (stop - start) * along(angle, seen, lit, ox, oy, oz, ix, iy, iz, p)
        return total * alpha_x * alpha_y / pi

    return matt


@cache
def matt_batch(
    normals: Callable[..., float], view: Callable[..., float], shadowed: Callable[..., float], counts: tuple[int, int]
) -> Batch:
    return over_pairs(matt_rule(normals, view, shadowed, counts))


# --- the model --------------------------------------------------------------------------------------------------------

HEIGHTS, TURNS = 20, 32  # light directions over which an albedo is summed


def light_directions(heights: int, turns: int) -> tuple[np.ndarray, np.ndarray]:
    """Directions (n, 3) and weights of a sum over the hemisphere with the cosine: even in azimuth, Gauss in the cosine."""
    nodes, weights = gauss(heights)
    z, azimuth = np.meshgrid(nodes, 2 * np.pi * (np.arange(turns) + 0.5) / turns, indexing="ij")
    weight = np.repeat(np.array(weights) * np.array(nodes), turns) * 2 * np.pi / turns
    return spherical(np.arccos(z), azimuth).reshape(-1, 3), weight


class Diffuse(Model):
    """The BRDF of matt facets over a model of masking and shadowing, by quadrature. oren1994; heitz2014.

    albedo: the share of light that a facet scatters, in (0, 1]. Light that meets a second facet is not followed.
    """

    def __init__(self, model: Masking, albedo: float = 1.0) -> None:
        if not isinstance(model, Masking):
            raise ValueError(f"model must be a model of masking such as Smith(GGX(0.3)), got {model!r}")
        if positive("albedo", albedo) > 1:
            raise ValueError(f"albedo must lie in (0, 1], got {albedo}")
        self.model, self.facet_albedo = model, float(albedo)
        self._parts = (type(model.ndf).kernel, model.view_kernel, model.shadowed_kernel)

    def evaluate(self, wo: Any, wi: Any) -> Any:
        """The BRDF, 1/sr, shapes (..., 3) -> (...); 0 if either direction is below the horizon. oren1994."""
        return self._by(FINE, wo, wi)

    def evaluate_with_error(self, wo: Any, wi: Any) -> tuple[Any, Any]:
        """The BRDF, and a bound of its error, from coarser rules and from rounding."""
        value = self._by(FINE, wo, wi)
        apart = np.maximum(*(abs(value - self._by(counts, wo, wi)) for counts in COARSER))
        return value, SAFETY * apart + rounding(value)

    def albedo(self, wo: Any) -> Any:
        """Share of light from wo that leaves again, shapes (..., 3) -> (...), by quadrature over the hemisphere."""
        return self.albedo_with_error(wo)[0]

    def albedo_with_error(self, wo: Any) -> tuple[Any, Any]:
        """The albedo, and a bound of its error, from a coarser rule, from the errors of the BRDF, and from rounding."""
        views = as_vectors("wo", wo)
        sums, within = [], 0.0
        for heights, turns in ((HEIGHTS, TURNS), (HEIGHTS * 2 // 3, TURNS * 3 // 4)):
            wi, weight = light_directions(heights, turns)
            value, error = self.evaluate_with_error(views[..., None, :], wi.astype(views.dtype))
            sums.append(value @ weight.astype(views.dtype))
            within = np.maximum(within, error @ weight.astype(views.dtype))
        return sums[0], SAFETY * abs(sums[0] - sums[1]) + within + rounding(sums[0])

    def _by(self, counts: tuple[int, int], wo: Any, wi: Any) -> Any:
        parameters = (self.model.parameters, self.model.ndf.slope_scale, self.model.ndf.reach)
        arrays = [vectors("wo", wo), vectors("wi", wi)]
        values = matt_batch(*self._parts, counts)(arrays, parameters)
        return values * values.dtype.type(self.facet_albedo)

    def __repr__(self) -> str:
        return f"Diffuse({self.model!r}, {self.facet_albedo:g})"
