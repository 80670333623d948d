"""A scene: one view, one light, one facet of a Beckmann surface. Every symbol of the report is a number there.

What the left side of a statement stands for is computed from its meaning - vectors, areas on the sphere, derivatives - and
not by the formula that is stated. `wrong` says where a statement does not hold in the scene.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from functools import cache
from typing import Any

import mpmath
import numpy as np
import sympy as sp
from around import Patch, reflected, turned_away, turned_to, whole_hemisphere
from microfacet.directions import spherical
from microfacet.statements.statement import Equation
from microfacet.visibility.masking import visible_norm
from scipy import integrate, special

AX, AY, N, BLEND = 0.5, 0.3, 3.7, 0.35
UP = np.array([0.0, 0.0, 1.0])
SAME, TOUCHING = 1e-8, 1e-7  # relative
Names = dict[str, Any]


# --- a Beckmann surface, from its definition ------------------------------------------------------------------------------


def D(m: np.ndarray, ax: float = AX, ay: float = AY) -> Any:
    m = np.atleast_2d(m)
    z = np.where(m[:, 2] > 0, m[:, 2], 1.0)
    value = np.exp(-((m[:, 0] / ax) ** 2 + (m[:, 1] / ay) ** 2) / z**2) / (np.pi * ax * ay * z**4)
    found = np.where(m[:, 2] > 0, value, 0.0)
    return found if len(found) > 1 else float(found[0])


def P22(x: Any, y: Any, ax: float = 1.0, ay: float = 1.0) -> Any:
    return np.exp(-((x / ax) ** 2) - (y / ay) ** 2) / (np.pi * ax * ay)


def alpha_along(w: np.ndarray) -> float:
    return float(np.hypot(AX * w[0], AY * w[1]) / np.hypot(w[0], w[1]))


def hidden(w: np.ndarray, alpha: float | None = None) -> float:
    """Lambda: exp(-a^2)/(2 a sqrt(pi)) - erfc(a)/2."""
    a = w[2] / (np.hypot(AX * w[0], AY * w[1]) if alpha is None else alpha * np.hypot(w[0], w[1]))
    return float(np.exp(-a * a) / (2 * a * np.sqrt(np.pi)) - special.erfc(a) / 2)


def cavity(w: np.ndarray, m: np.ndarray) -> float:
    """Of a groove's opening, what its other wall leaves; over what the facet itself would show."""
    cosine, opposite = float(w @ m), float(w @ (m * [-1, -1, 1]))
    if cosine <= 0:
        return 0.0
    wall = 2 * m[2]
    return (w[2] - max(opposite, 0) / wall) / (cosine / wall) if opposite < 0 else 1.0


def by_steps(function: Callable[[Any], Any], at: float) -> float:
    with mpmath.workdps(40):
        return float(mpmath.diff(function, mpmath.mpf(at)))


def half(o: np.ndarray, i: np.ndarray) -> Any:
    total = o + i
    return total / np.sqrt(total @ total)


def half_per_light(o: np.ndarray, i: np.ndarray) -> float:
    """Area on the sphere that half vectors cover for an area of light directions, by complex steps."""
    first = np.cross(i, [0.3, 0.5, 0.8])
    first /= np.linalg.norm(first)
    moved = [(half(o, i + 1e-30j * axis)).imag * 1e30 for axis in (first, np.cross(i, first))]
    return float(np.linalg.norm(np.cross(*moved)))


# --- scenes ---------------------------------------------------------------------------------------------------------------

VIEW, LIGHT = spherical(1.0, 0.6), spherical(1.15, 2.0)
FACETS = {
    "front": spherical(0.5, 1.2),
    "steep": spherical(1.25, 0.9),  # its groove masks
    "steep from the other side": spherical(1.25, 2.2),
    "turned from the viewer": spherical(1.2, 3.4),
    "turned from the light": spherical(1.2, -0.9),
}


@cache
def _patches() -> tuple[Patch, Patch]:
    return turned_to(VIEW), turned_away(VIEW)


@cache
def _areas() -> Names:
    """What the viewer sees of the facets, by a rule on the sphere."""
    front, back = _patches()
    plus, minus = (abs(part.sum(part.directions @ VIEW * D(part.directions))) for part in (front, back))
    seen = plus / (1 + hidden(VIEW))
    light = reflected(VIEW, lambda i: D(_halves(i)) / (1 + hidden(VIEW)) / (4 * VIEW[2]))
    everything = whole_hemisphere(AX)
    return {
        "A_plus": plus,
        "A_minus": minus,
        "seen": seen,
        "furnace": light,
        "upright": everything.sum(everything.directions[:, 2] * D(everything.directions)),
    }


def _halves(i: np.ndarray) -> np.ndarray:
    total = VIEW + i
    return total / np.linalg.norm(total, axis=-1, keepdims=True)


def names(o: np.ndarray = VIEW, i: np.ndarray = LIGHT, m: np.ndarray = FACETS["front"]) -> Names:
    """Every symbol that is a number of the scene."""
    h, Lo, Li = half(o, i), hidden(o), hidden(i)
    vectors = {"o": o, "i": i, "m": m}
    found: Names = {f"{part}_{name}": v[k] for name, v in vectors.items() for k, part in enumerate("xyz")}
    found |= {f"{name}_vector": v for name, v in vectors.items()} | {"h_vector": h, "g_vector": UP}
    found |= {f"theta_{name}": float(np.arctan2(np.hypot(v[0], v[1]), v[2])) for name, v in vectors.items()}
    found |= {f"phi_{name}": float(np.arctan2(v[1], v[0])) for name, v in vectors.items()}
    found |= {"mu_o": o[2], "mu_i": i[2], "om": o @ m, "im": i @ m, "oh": o @ h, "ih": i @ h, "gm": m[2]}
    found |= {"alpha_x": AX, "alpha_y": AY, "alpha_o": alpha_along(o), "alpha": 0.4, "n": N, "lambda_": BLEND}
    found |= {"Lambda_o": Lo, "Lambda_i": Li, "G1": (o @ m > 0) / (1 + Lo), "G1_i": (i @ m > 0) / (1 + Li), "D": D(m)}
    found |= {"F": 0.3, "F_0": 0.07, "c": 0.37, "eta": 1.7, "kappa": 2.3, "phi": 1.1, "k": 0.21, "q": 0.8, "gamma": 0.9}
    found |= {"G1_h": 1 / (1 + Lo), "G2": 1 / (1 + Lo + Li), "G2_h": 1 / (1 + Lo + Li), "D_h": D(h)}
    found |= {"x": -m[0] / m[2], "y": -m[1] / m[2], "A_plus": _areas()["A_plus"], "A_minus": _areas()["A_minus"]}
    found |= {"o_dot_m": o @ m, "o_dot_opposite": o @ (m * [-1, -1, 1])}
    return found


def _P2(q: Any) -> Any:
    along = alpha_along(VIEW)
    return np.exp(-((q / along) ** 2)) / (np.sqrt(np.pi) * along)


FUNCTIONS: dict[str, Any] = {
    "P2": _P2,
    "P22": P22,
    "chi": lambda value: 1.0 if value > 0 else 0.0,
    "Abs": lambda value: np.linalg.norm(value),
}


def value(form: Any, known: Names) -> Any:
    """The form as a number, or a vector, of the scene."""
    form = sp.sympify(form)
    whole = form.replace(lambda e: isinstance(e, sp.Integral), lambda e: sp.Float(_integral(e, known), 17))
    free = sorted(map(str, whole.free_symbols))
    return _function(whole, free)(*(known[name] for name in free))


def _function(form: Any, arguments: list[str]) -> Callable[..., Any]:
    found: Callable[..., Any] = sp.lambdify(arguments, form.doit(), modules=[FUNCTIONS, "scipy", "numpy"])
    return found


def _integral(e: sp.Integral, known: Names) -> float:
    variables = [str(limit[0]) for limit in e.limits]
    outer = {name: known[name] for name in map(str, e.function.free_symbols) if name not in variables}
    inside = _function(e.function, [*variables, *outer])
    if len(variables) == 2:
        return _over_the_plane(lambda x, y: inside(x, y, *outer.values()))
    low, high = (float(value(end, known)) for end in e.limits[0][1:])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of integrals that do not exist
        return float(integrate.quad(lambda q: inside(q, *outer.values()), low, high, epsabs=1e-12, epsrel=1e-12, limit=200)[0])


def _over_the_plane(density: Callable[[Any, Any], Any], count: int = 96) -> float:
    """In polar slopes after unstretching; radius as a tangent."""
    t, w = np.polynomial.legendre.leggauss(count)
    angle = np.pi / 4 * (t + 1)
    turn = 2 * np.pi * (np.arange(64) + 0.5) / 64
    r, turn = np.meshgrid(np.tan(angle), turn, indexing="ij")
    with np.errstate(all="ignore"):
        values = density(AX * r * np.cos(turn), AY * r * np.sin(turn)) * AX * AY * r * (1 + r * r)
    return float(np.sum(w[:, None] * np.pi / 4 * values) * 2 * np.pi / 64)


# --- what left sides stand for ----------------------------------------------------------------------------------------------

Left = tuple[Any, Names]  # the number, and the names with which the right side is to be evaluated
MEETS = "meets"  # the name that says whether a bound is reached


def everywhere(left: Callable[[Names], Any]) -> Callable[[], Iterator[Left]]:
    def run() -> Iterator[Left]:
        for facet in FACETS.values():
            known = names(m=facet)
            yield left(known), known

    return run


def here(left: Callable[[Names], Any], **more: Any) -> Callable[[], Iterator[Left]]:
    def run() -> Iterator[Left]:
        known = names() | {name: made() if callable(made) else made for name, made in more.items()}
        yield left(known), known

    return run


def _lengths(n: Names) -> Any:
    return n["o_vector"], n["i_vector"], n["m_vector"]


def _facing(n: Names, *vectors: str) -> float:
    return float(all(n[v] @ n["m_vector"] > 0 for v in vectors))


def _visible(n: Names) -> float:
    """The share of one normal in what is seen, the whole taken on the sphere."""
    o, _, m = _lengths(n)
    return float(max(o @ m, 0) * D(m) / (1 + hidden(o)) / _areas()["seen"])


def _along_view(n: Names) -> float:
    """What a facet of slope q along the view shows per area of the plane."""
    o, m = spherical(n["theta_o"], 0.0), np.array([-n["q"], 0.0, 1.0])
    return float(o @ m)


def _quarter_turn(n: Names) -> Any:
    """The view turned by half a turn about the facet's normal."""
    o, _, m = _lengths(n)
    return -(np.eye(3) - 2 * np.outer(m, m)) @ o


def _bisector(n: Names) -> Any:
    o, i, _ = _lengths(n)
    return (o + i) / (2 * np.cos(np.arccos(o @ i) / 2))


def _original_kelemen(n: Names) -> float:
    o, i, _ = _lengths(n)
    return float(2 * o[2] * i[2] / (1 + o @ i))


def _at_half(left: Callable[[Names], Any]) -> Callable[[], Iterator[Left]]:
    def run() -> Iterator[Left]:
        known = names(m=half(VIEW, LIGHT))
        yield left(known), known
        yield 0.0, names(m=FACETS["turned from the viewer"])

    return run


def _blended(n: Names, blend: float) -> float:
    both = sorted((1 / (1 + n["Lambda_o"]), 1 / (1 + n["Lambda_i"])))
    return float(blend * both[0] * both[1] + (1 - blend) * both[0])


def _by_both(n: Names, blend: float) -> float:
    small, large = sorted((n["Lambda_o"], n["Lambda_i"]))
    return 1 / (1 + large + blend * small)


def _rho(o: np.ndarray, i: np.ndarray, F: float = 0.3) -> float:
    """Light sent per light received, from the share of facets that mirror one into the other."""
    facing = D(half(o, i)) * half_per_light(o, i) * (o @ half(o, i))  # projected area per solid angle of light
    return float(F * facing / (1 + hidden(o) + hidden(i)) / (o[2] * i[2]))


def _light_density(o: np.ndarray, i: np.ndarray) -> float:
    """Of mirror directions of visible normals: the normals' density times area of half vectors per area of light."""
    h = half(o, i)
    return float((o @ h) * D(h) / (1 + hidden(o)) / _areas()["seen"] * half_per_light(o, i))


def _moved(n: Names) -> tuple[np.ndarray, np.ndarray]:
    o, _, m = _lengths(n)
    direction, normal = o / [AX, AY, 1], m * [AX, AY, 1]
    return direction / np.linalg.norm(direction), normal / np.linalg.norm(normal)


def _facing_over_heights(o: np.ndarray, m: np.ndarray) -> float:
    return float(o @ m / (o[2] * m[2]))


def _seen_per_slopes(o: np.ndarray, m: np.ndarray, ax: float, ay: float) -> float:
    a = o[2] / np.hypot(ax * o[0], ay * o[1])
    Lambda = np.exp(-a * a) / (2 * a * np.sqrt(np.pi)) - special.erfc(a) / 2
    return float((o @ m) * D(m, ax, ay) * m[2] ** 3 / (1 + Lambda) / o[2])


def _height(x: Any, y: Any) -> Any:
    return mpmath.sin(1.3 * x) * mpmath.exp(0.4 * y) + x * y


LEFT: dict[str, Callable[[], Iterator[Left]]] = {
    "geometry.slopes.projected_area": here(lambda n: _areas()["upright"]),
    "geometry.ggx.projected_area": here(lambda n: 1.0),
    "geometry.beckmann.projected_area": here(lambda n: _areas()["upright"]),
    "geometry.blinn_phong.P22": here(lambda n: n["z_m"] ** (N + 4), D_m=FACETS["front"][2] ** N),
    "visibility.masking.projected_area": here(lambda n: _areas()["seen"]),
    "visibility.masking.D_visible": here(_visible),
    "visibility.masking.visible_norm": here(lambda n: _areas()["seen"] / n["mu_o"]),
    "visibility.smith.Lambda": here(lambda n: n["Lambda_o"]),
    "visibility.smith.facet": here(_along_view),
    "visibility.smith.signed": here(lambda n: n["A_plus"] - n["A_minus"]),
    "visibility.v_cavity.opposite": here(lambda n: n["m_vector"] * [-1, -1, 1]),
    "visibility.v_cavity.opening": here(lambda n: n["mu_o"]),
    "visibility.v_cavity.share": here(lambda n: 1 + n["o_dot_opposite"] / n["o_dot_m"]),
    "visibility.v_cavity.G1": everywhere(lambda n: cavity(n["o_vector"], n["m_vector"])),
    "visibility.v_cavity.G2": everywhere(
        lambda n: min(cavity(n["o_vector"], n["m_vector"]), cavity(n["i_vector"], n["m_vector"]))
    ),
    "visibility.implicit.G1": everywhere(lambda n: _facing(n, "o_vector") * (n["o_vector"] @ UP)),
    "visibility.implicit.G2": here(lambda n: (n["o_vector"] @ UP) * (n["i_vector"] @ UP)),
    "visibility.kelemen.G1": _at_half(lambda n: (_original_kelemen(n) * n["mu_o"] / n["mu_i"]) ** 0.5),
    "visibility.kelemen.G2": lambda: _first(_at_half(_original_kelemen)),
    "visibility.schlick_smith.exact": here(lambda n: None, Lambda_o=(1 / VIEW[2] - 1) / 2),
    "material.fresnel.schlick": here(lambda n: np.interp((1 - n["c"]) ** 5, [0, 1], [n["F_0"], 1])),
    "material.fresnel.normal": here(lambda n: abs((n["eta"] - 1 + 1j * n["kappa"]) / (n["eta"] + 1 + 1j * n["kappa"])) ** 2),
    "material.reflection.mirror": here(_quarter_turn),
    "material.reflection.half_vector": here(_bisector),
    "material.reflection.half_angle": here(
        lambda n: by_steps(lambda g: -mpmath.cos(g / 2), n["gamma"]) / by_steps(lambda g: -mpmath.cos(g), n["gamma"]),
        sin_half=np.sin(0.45),
        cos_half=np.cos(0.45),
    ),
    "material.reflection.jacobian": here(lambda n: half_per_light(VIEW, LIGHT)),
    "material.reflection.weak_furnace": here(
        lambda n: _areas()["furnace"], **{str(visible_norm.symbol): lambda: _areas()["seen"] / VIEW[2]}
    ),
    "visibility.shadowing.lambda": here(lambda n: 1 - 1 / (1 + 4.41 * n["phi"])),
    "visibility.shadowing.direction": here(lambda n: _blended(n, BLEND)),
    "visibility.shadowing.height_direction": here(lambda n: _by_both(n, BLEND)),
    "visibility.shadowing.smaller": here(lambda n: _blended(n, 0.0)),
    "visibility.shadowing.same_azimuth": here(lambda n: _blended(n, 0.0)),
    "visibility.shadowing.far_direction": here(lambda n: _blended(n, 1.0)),
    "visibility.shadowing.far_height_direction": here(lambda n: _by_both(n, 1.0)),
    "brdf.microfacet.rho": here(lambda n: _rho(VIEW, LIGHT), p_light=lambda: _light_density(VIEW, LIGHT)),
    "brdf.microfacet.weight": here(lambda n: _rho(VIEW, LIGHT) * LIGHT[2] / _light_density(VIEW, LIGHT)),
    "brdf.microfacet.reciprocity": here(lambda n: _rho(VIEW, LIGHT), rho_io=lambda: _rho(LIGHT, VIEW)),
    "visibility.stretching.slope": here(
        lambda n: by_steps(lambda s: _height(AX * s, AY * n["y"]), n["x"]),
        slope_by_chain=lambda: by_steps(lambda s: _height(AX * s, AY * names()["y"]), names()["x"]),
        slope_before=lambda: by_steps(lambda s: _height(s, AY * names()["y"]), AX * names()["x"]),
    ),
    "visibility.stretching.P22": here(lambda n: P22(n["x"], n["y"], AX, AY)),
    "visibility.stretching.facing": here(
        lambda n: _facing_over_heights(*_moved(n)),
        facing_before=lambda: _facing_over_heights(VIEW, FACETS["front"]),
        slope_over_sight=lambda: (VIEW[0] * names()["x"] + VIEW[1] * names()["y"]) / VIEW[2],
    ),
    "visibility.stretching.a": here(
        lambda n: 1 / np.tan(n["theta_o"]), **{f"{part}_sight": _moved(names())[0][k] for k, part in enumerate("xyz")}
    ),
    "visibility.stretching.v_cavity": here(lambda n: cavity(*_moved(n)), G1_before=lambda: cavity(VIEW, FACETS["front"])),
    "visibility.stretching.visible_normals": here(
        lambda n: _seen_per_slopes(*_moved(n), AX, AY) * AX * AY,
        visible_before=lambda: _seen_per_slopes(VIEW, FACETS["front"], 1.0, 1.0),
    ),
    "visibility.stretching.sight": here(lambda n: np.tan(np.arctan2(VIEW[2], np.hypot(AX * VIEW[0], AY * VIEW[1])))),
}


def _first(scenes: Callable[[], Iterator[Left]]) -> Iterator[Left]:
    yield next(scenes())


# --- bounds: they hold, and are touched -----------------------------------------------------------------------------------


def _shadowing(meets: Callable[[float, float], bool]) -> Callable[[], Iterator[Left]]:
    """Two forms of shadowing, and from the smaller Lambda and the blend whether they are the same."""

    def run() -> Iterator[Left]:
        generic, unmasked = [(0.5, 0.3, 0.4), (0.2, 1.5, 0.7)], [(0.5, 0.0, 0.3), (0.0, 0.4, 0.9)]
        for Lo, Li, blend in [*generic, *unmasked, (0.5, 0.3, 0.0), (0.3, 0.6, 1.0)]:
            known = {"Lambda_o": Lo, "Lambda_i": Li, "lambda_": blend, "G1": 1 / (1 + Lo), "G1_i": 1 / (1 + Li)}
            yield None, known | {MEETS: meets(min(Lo, Li), blend)}

    return run


def bound(*pairs: tuple[float, bool]) -> Callable[[], Iterator[Left]]:
    """Numbers that keep to the bound, some of which reach it."""
    return lambda: iter([(number, {MEETS: meets}) for number, meets in pairs])


def _ward_area(alpha: float) -> float:
    x = mpmath.mpf(alpha) ** -2
    return float(mpmath.quad(lambda s: mpmath.exp(-s) / (1 + s / x) ** 2, [0, 5, 40]))


def _masked_share(theta: float, k: float | None) -> float:
    """What a masking function of the view alone shows: Implicit's, or Schlick's with this k."""
    w = spherical(theta, 0.0)
    G1 = w[2] if k is None else w[2] / (w[2] * (1 - k) + k)
    return float(G1 * (1 + hidden(w, 0.4)))


def _area(alpha: float) -> float:
    """Of a Beckmann surface: that of the plane, if it is smooth."""
    return float(1 + np.sqrt(np.pi) * alpha * special.erfcx(1 / alpha) / 2)


def _turned_area(theta: float) -> float:
    seen = turned_to(spherical(theta, 0.0))
    return seen.sum(D(seen.directions, 0.4, 0.4))


K, NORMAL, SMOOTH, GRAZING = 0.4 * (2 / np.pi) ** 0.5, 1e-5, 1e-4, 1e-10
LEFT |= {
    "visibility.shadowing.height_above_separable": _shadowing(lambda least, blend: least == 0),
    "visibility.shadowing.height_direction_above_height": _shadowing(lambda least, blend: least == 0 or blend == 1),
    "visibility.shadowing.height_direction_bound": _shadowing(lambda least, blend: least == 0 or blend == 0),
    "visibility.shadowing.direction_bound": _shadowing(lambda least, blend: least == 0 or blend == 0),
    "brdf.microfacet.positivity": lambda: bound((_rho(VIEW, LIGHT), False), (0.0, True))(),  # the second of light from below
    "brdf.microfacet.energy": bound(
        *((1 - mu * np.log1p(1 / mu), mu == GRAZING) for mu in (0.9, 0.1, GRAZING))
    ),  # GGX, alpha 1
    "validation.table1.ward": lambda: bound((_ward_area(0.5), False), (_ward_area(SMOOTH), True))(),
    "validation.table2.implicit_beckmann": bound((_masked_share(0.9, None), False), (_masked_share(NORMAL, None), True)),
    "validation.table2.schlick_smith_beckmann": bound((_masked_share(0.9, K), False), (_masked_share(NORMAL, K), True)),
    **dict.fromkeys(
        ("validation.table2.kelemen_beckmann_above", "validation.table2.kelemen_ggx_above"),
        bound((_area(0.4), False), (_area(SMOOTH), True)),
    ),
    **dict.fromkeys(
        ("validation.table2.kelemen_beckmann_grazing", "validation.table2.kelemen_ggx_grazing"),
        lambda: bound((_turned_area(np.radians(89.0)), False), (1.0, True))(),  # a smooth surface shows the plane's area
    ),
}


# --- the check ------------------------------------------------------------------------------------------------------------


@cache
def _lefts(key: str) -> tuple[Left, ...]:
    return tuple(LEFT[key]())


def wrong(equation: Equation) -> str:
    """A sentence if the statement does not hold in its scenes, else nothing."""
    if equation.key not in LEFT:
        return ""
    with np.errstate(all="ignore"):
        return _wrong(equation)


def _wrong(equation: Equation) -> str:
    for left, known in _lefts(equation.key):
        there = np.asarray(value(equation.symbol, known) if left is None else left, float)
        for part in ("means", "equals"):
            form = getattr(equation, part)
            if form is None:
                continue
            right = np.asarray(value(form, known), float)
            gap = (there - right) / max(np.max(np.abs(there)), np.max(np.abs(right)), 1e-300)
            if not _keeps(equation.relation, gap):
                return f"{part} is {right}, but the left side is {there}"
            if known.get(MEETS, equation.relation == "=") != bool(np.max(np.abs(gap)) <= TOUCHING):
                return f"{part} is {right}, and the left side, {there}, reaches it where it should not, or the other way round"
    return ""


def _keeps(relation: str, gap: Any) -> bool:
    if relation == "=":
        return bool(np.all(np.abs(gap) <= SAME))
    return bool(np.all((-1 if relation in ("<", r"\le") else 1) * gap >= -SAME))
