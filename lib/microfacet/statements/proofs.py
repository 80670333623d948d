"""Helpers for proofs."""

from __future__ import annotations

from typing import Any

import sympy as sp


def residuals_of_forms(it: Any, left: bool = False) -> list[Any]:
    """Each printed form of a statement less its last one, after the substitutions of `where`; left: the left side as well."""
    printed = [*([it.symbol] if left else []), it.means, it.equals]
    forms = [sp.sympify(form).subs(it.where) for form in printed if form is not None]
    return [form - forms[-1] for form in forms[:-1]]


def under_integral(it: Any, bounded: Any) -> Any:
    """The definition with its one integral replaced by another form of it."""
    (whole,) = it.means.atoms(sp.Integral)
    return it.means.xreplace({whole: bounded})
