"""Rows of the tables in the chapter for those who write a renderer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import microfacet as mf
import mpmath
import numpy as np
from microfacet.geometry.roughness import CONVENTIONS
from microfacet.statements.notation import Direction, latex
from microfacet.statements.statement import Equation
from numpy.typing import NDArray

Array = NDArray[Any]
DIGITS = 15

# --- which form of G2, and which model ------------------------------------------------------------------------------------


class FormOfG2(NamedTuple):
    """Its name, and what it takes."""

    label: str
    takes: str


FORMS = {  # by their names in the figures' data
    "V-cavities": FormOfG2("V-cavities", "the half vector"),
    "Smith, height": FormOfG2("Smith, height-correlated", r"both $\Lambda$"),
    "Smith, none": FormOfG2("Smith, separable", r"both $\Lambda$"),
    "Smith, direction": FormOfG2("Smith, direction-correlated", r"both $\Lambda$ and the azimuth"),
    "Smith, height-direction": FormOfG2("Smith, correlated by both", r"both $\Lambda$ and the azimuth"),
}


class Deviation(NamedTuple):
    """A form of G2 beside measured surfaces: the error of its albedo at its lowest and highest, and its lobe's farthest."""

    least: float
    most: float
    farthest: float


def forms_of_G2(measured: Mapping[str, Array]) -> dict[str, Deviation]:
    """measured: the arrays of the figure `measured_distances`."""
    names = [str(name) for name in measured["names"][0]]
    off = measured["model_albedo"] - measured["albedo"][..., :1]
    distance = measured["distance"][..., 0]
    return {
        name: Deviation(float(off[..., k].min()), float(off[..., k].max()), float(distance[..., k].max()))
        for k, name in enumerate(names)
    }


def picture_errors(maps: Mapping[str, Array], slopes: str) -> Array:
    """Errors of a picture by the model of which nothing is simplified but what happens after the first bounce, each with its
    bound: (roughnesses, compensations).

    maps: the arrays of the figure `enough_map`. slopes: "ggx" or "beckmann".
    """
    most = maps[f"{slopes}_most"][list(maps["measures"]).index("picture")]
    return np.asarray(most[:, maps[f"{slopes}_complete"]])


# --- numbers to test with ---------------------------------------------------------------------------------------------------


class Reference(NamedTuple):
    """A statement's value to 50 digits, and by how many units in the last place its kernels are off in both precisions."""

    what: str
    at: str
    value: mpmath.mpf
    ulps: tuple[float, float]

    @property
    def row(self) -> list[str]:
        digits = mpmath.nstr(self.value, DIGITS, min_fixed=-4, max_fixed=8, strip_zeros=False)
        mantissa, _, power = digits.partition("e")
        return [self.what, self.at, rf"${mantissa} \cdot 10^{{{int(power)}}}$" if power else mantissa]


Decimals = tuple[str, str, str] | str
UP, ASIDE = ("0.48", "0.64", "0.6"), ("-0.28", "0", "0.96")  # of unit length, exactly
ROUGHNESS = (("0.5", "0.5"), ("0.6", "0.3"), ("0.01", "0.01"))
SLOPES = ("0.1", "1", "5")


def references() -> list[Reference]:
    """Values at arguments that decimals state exactly."""
    distributions = {"GGX": "geometry.ggx", "Beckmann": "geometry.beckmann"}
    D = [_reference(f"$D$ of {name}", f"{key}.D", UP, *alpha) for name, key in distributions.items() for alpha in ROUGHNESS[:2]]
    Lambda = [_reference(rf"$\Lambda$ of {name}", f"{key}.Lambda", a) for name, key in distributions.items() for a in SLOPES]
    rho = [_reference(r"$\rho$ of GGX, $F = 1$", "brdf.microfacet.ggx", UP, ASIDE, *alpha) for alpha in ROUGHNESS]
    albedo = [_reference(r"albedo of GGX, $\alpha = 1$, $F = 1$", "brdf.microfacet.anchor", mu) for mu in ("0.1", "0.6")]
    return [*D, *Lambda, *rho, *albedo, *_reflectances()]


def _reflectances() -> list[Reference]:
    return [
        _reference("$F$, dielectric", "material.fresnel.dielectric", "0.5", "1.5"),
        _reference("$F$, conductor", "material.fresnel.conductor", "0.5", "0.2", "3.9"),
        _reference("$F$, Schlick", "material.fresnel.schlick", "0.5", "0.04"),
    ]


def _reference(what: str, key: str, *arguments: Decimals) -> Reference:
    statement = mf.equations[key]
    at = ", ".join(f"${_argument(name)} = {_shown(value)}$" for name, value in zip(statement.over, arguments, strict=True))
    decimals = [number for value in arguments for number in ((value,) if isinstance(value, str) else value)]
    with mpmath.workdps(60):
        value = statement.exact(*map(mpmath.mpf, decimals))
    return Reference(what, at, value, (_ulps(statement, decimals, np.float64), _ulps(statement, decimals, np.float32)))


def _ulps(statement: Equation, decimals: Sequence[str], real: type) -> float:
    """How far the kernel is from the exact value of the numbers that are given to it."""
    given: Array = np.array(decimals, real)
    exact = statement.exact(*map(float, given))
    return float(abs(mpmath.mpf(float(statement.kernel(*given))) - exact) / mpmath.mpf(float(np.spacing(real(exact)))))


def _argument(name: Any) -> str:
    return rf"\{name}" if isinstance(name, Direction) else latex(name)


def _shown(value: Decimals) -> str:
    return value if isinstance(value, str) else f"({', '.join(value)})"


class Albedos(NamedTuple):
    """Albedos of GGX for F = 1 as rows of a table, and the largest bound of their errors."""

    rows: list[list[str]]
    bound: float


def albedos(alpha: Sequence[float], degrees: Sequence[float]) -> Albedos:
    """A row for each roughness, a column for each view."""
    wo = mf.spherical(np.radians(degrees))
    values, bounds = mf.Microfacet(mf.Smith(mf.GGX(np.array(alpha)[:, None]))).albedo_with_error(wo)
    rows = [[f"{a:g}", *(f"{value:.6f}" for value in row)] for a, row in zip(alpha, values, strict=True)]
    return Albedos(rows, float(np.max(bounds)))


# --- roughness of other programs ------------------------------------------------------------------------------------------

USED_BY = {
    "squared": ("$r^2$", "glTF, Disney, Filament, Unreal, Blender"),
    "alpha": ("$r$", "Mitsuba"),
    "pbrt-v3": (r"a fit in $\ln r$", "pbrt-v3"),
    "pbrt-v4": (r"$\sqrt{r}$", "pbrt-v4"),
    "phong": (r"$\sqrt{2/(r + 2)}$", "exponents of Phong and Blinn"),
}


def conventions(roughness: float, exponent: float) -> list[list[str]]:
    """A row for each convention that the library knows: its name, alpha, who uses it, and alpha for an example."""
    examples = {name: exponent if name == "phong" else roughness for name in CONVENTIONS}
    alphas = {name: float(mf.alpha_from_roughness(r, name)) for name, r in examples.items()}
    return [[f"`{name}`", *USED_BY[name], f"{r:g}", f"{alphas[name]:.4f}"] for name, r in examples.items()]
