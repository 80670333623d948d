"""The parameters for which the ticks and crosses of the two tables are proved, worded from the statements that prove them."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import sympy as sp
from microfacet.geometry import beckmann, blinn_phong, ggx
from microfacet.statements.notation import alpha, mu_o, n
from microfacet.statements.statement import Equation
from microfacet.validation.kelemen import GRAZING_ANGLES, KELEMEN_ROUGH, STEEP_ANGLES
from microfacet.validation.slopes_along_view import TABLE_2_FAMILIES
from microfacet.validation.unnormalized import phong, ward_area
from microfacet.validation.unphysical import (
    BOX,
    IMPLICIT_UP_TO,
    SCHLICK_UP_TO,
    halved_ggx,
    implicit_beckmann,
    implicit_ggx,
    schlick_beckmann,
    schlick_ggx,
)


@dataclass(frozen=True)
class Quantifier:
    """For which parameters a tick or a cross of the tables is proved.

    every: the parameters that are free; but: the exception; within: the range of the other parameters. All as Markdown.
    keys: the statements that prove it.
    """

    verdict: str
    keys: tuple[str, ...]
    every: str
    but: str = ""
    within: str = ""

    @property
    def brief(self) -> str:
        return f"every {self.every}" + (f" but {self.but}" if self.but else "") if self.keys else "–"

    @property
    def summary(self) -> str:
        return self.brief + (f"; {self.within}" if self.within else "")


def vanishes_at(statement: Equation, symbol: sp.Symbol, value: Any) -> Any:
    """The value, where the deviation that the statement gives in closed form is 0, and beside which it is not."""
    closed = sp.sympify(statement.equals).doit()
    if sp.simplify(closed.subs(symbol, value)) != 0 or sp.simplify(closed.subs(symbol, sp.sympify(value) / 2)) == 0:
        raise ValueError(f"{statement.key} does not vanish at {symbol} = {value} alone")
    return value


def _only_exponent() -> str:
    (exponent,) = sp.solve(phong.equals.doit(), n)
    return f"${sp.latex(vanishes_at(phong, n, exponent), order='rev-lex')}$"


def _view_above(*statements: Equation) -> str:
    """The view in which closed-form deviations vanish."""
    (angle,) = {sp.acos(vanishes_at(statement, mu_o, 1)) for statement in statements}
    return rf"${sp.latex(sp.deg(angle))}^\circ$"


def _box_label(box: Mapping[str, tuple[float, float]]) -> str:
    return rf"${box['alpha'][0]:g} \le \alpha \le {box['alpha'][1]:g}$"


def _up_to(largest: sp.Expr) -> str:
    return rf"over Beckmann for {_box_label(BOX)}, over GGX for $\alpha \le {sp.latex(largest)}$"


def _passes(name: str) -> Quantifier:
    keys = tuple(f"validation.table2.{name}_{family}" for family in TABLE_2_FAMILIES)
    return Quantifier("holds", keys, r"$\alpha$ and view")


def quantifiers() -> Mapping[str, Quantifier]:
    """By row of the tables: the parameters for which the row's verdict is proved, none if there is no proof."""
    kelemen = tuple(f"validation.table2.kelemen_{f}_{side}" for f in ("beckmann", "ggx") for side in ("above", "grazing"))
    crossing = (
        rf"too much up to ${STEEP_ANGLES[1]:g}^\circ$, too little from ${GRAZING_ANGLES[0]:g}^\circ$,"
        rf" for {_box_label({'alpha': KELEMEN_ROUGH})}"
    )
    view = _view_above(implicit_ggx, schlick_ggx, halved_ggx)
    proved = {
        "Blinn-Phong": Quantifier("fails", (phong.key,), "$n$", _only_exponent()),
        "Blinn-Phong, normalised": Quantifier("holds", (blinn_phong.normalized_projected_area.key,), "$n$"),
        "Ward": Quantifier("fails", (ward_area.key,), r"$\alpha$"),
        "Beckmann": Quantifier("holds", (beckmann.projected_area.key,), r"$\alpha$"),
        "GGX": Quantifier("holds", (ggx.projected_area.key,), r"$\alpha$"),
        "Smith": _passes("smith"),
        "V-cavities": _passes("v_cavity"),
        "Implicit": Quantifier("fails", (implicit_beckmann.key, implicit_ggx.key), "view", view, _up_to(IMPLICIT_UP_TO)),
        "Kelemen": Quantifier("fails", kelemen, "view", "one", crossing),
        "Schlick-Smith": Quantifier("fails", (schlick_beckmann.key, schlick_ggx.key), "view", view, _up_to(SCHLICK_UP_TO)),
        "Schlick-Smith, halved": Quantifier(
            "fails",
            (halved_ggx.key,),
            "view",
            rf"{view}, $\alpha$ but ${vanishes_at(halved_ggx, alpha, 1)}$",
            "over GGX; at the exception it is Smith's",
        ),
    }
    return defaultdict(lambda: Quantifier("", (), ""), proved)
