"""The symbols of the field, once: what every statement is written in.

Names are ASCII so that generated code can use them; `LATEX` says how the report prints those that sympy would not
print the way the field writes them.
"""

from __future__ import annotations

from typing import Any

import sympy as sp
from sympy.core.function import AppliedUndef
from sympy.printing.latex import LatexPrinter

# --- roughness and slopes ---------------------------------------------------------------------------------------

alpha, alpha_x, alpha_y, alpha_o = sp.symbols("alpha alpha_x alpha_y alpha_o", positive=True)
n = sp.Symbol("n", positive=True)
x, y, q = sp.symbols("x y q", real=True)  # slopes of the microsurface along x, along y, along the view direction
a, t, u, v = sp.symbols("a t u v", positive=True)  # a = 1/(alpha tan theta); t a squared tangent; u, v in (0, 1)

# --- angles and cosines -----------------------------------------------------------------------------------------

theta_o, theta_i, theta_m = sp.symbols("theta_o theta_i theta_m", positive=True)
phi_o, phi_i, phi_m, phi = sp.symbols("phi_o phi_i phi_m phi", real=True)
mu_o, mu_i, mu_m = sp.symbols("mu_o mu_i mu_m", positive=True)  # cosines to the geometric normal
om, im, oh, ih = sp.symbols("om im oh ih", real=True)  # wo.wm, wi.wm, wo.wh, wi.wh
gm = sp.Symbol("gm", real=True)  # wm.wg

# --- abstract values, where a statement builds on others ----------------------------------------------------------

D, F, G1, G2, Lambda_o, Lambda_i = sp.symbols("D F G1 G2 Lambda_o Lambda_i", nonnegative=True)
P22 = sp.Function("P22")
P2 = sp.Function("P2")

LATEX: dict[sp.Symbol, str] = {
    x: r"\tilde{x}",
    y: r"\tilde{y}",
    om: r"\left\langle \omega_o, \omega_m \right\rangle",
    im: r"\left\langle \omega_i, \omega_m \right\rangle",
    oh: r"\left( \omega_o \cdot \omega_h \right)",
    ih: r"\left( \omega_i \cdot \omega_h \right)",
    gm: r"\left( \omega_m \cdot \omega_g \right)",
    mu_o: r"\cos \theta_o",
    mu_i: r"\cos \theta_i",
    mu_m: r"\cos \theta_m",
    Lambda_o: r"\Lambda(\omega_o)",
    Lambda_i: r"\Lambda(\omega_i)",
    D: r"D(\omega_m)",
    F: r"F(\omega_o, \omega_h)",
    G1: r"G_1(\omega_o, \omega_m)",
    G2: r"G_2(\omega_o, \omega_i, \omega_m)",
}


FUNCTIONS: dict[str, str] = {
    "P2": "P_2",
    "P22": "P_{22}",
    "Lambda_GGX": r"\Lambda",
    "Lambda_Beckmann": r"\Lambda",
    "Lambda_student": r"\Lambda",
    "lambda": r"\lambda",
}


class Direction:
    """A unit vector: its name, its components, its polar angles in radians."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.x, self.y, self.z = sp.symbols(f"x_{name} y_{name} z_{name}", real=True)
        self.theta = sp.Symbol(f"theta_{name}", positive=True)
        self.phi = sp.Symbol(f"phi_{name}", real=True)
        self.symbol = sp.Symbol(f"omega_{name}")

    @property
    def components(self) -> tuple[sp.Symbol, sp.Symbol, sp.Symbol]:
        return self.x, self.y, self.z

    @property
    def spherical(self) -> dict[sp.Symbol, sp.Expr]:
        """The components as functions of the angles."""
        sine = sp.sin(self.theta)
        return {self.x: sine * sp.cos(self.phi), self.y: sine * sp.sin(self.phi), self.z: sp.cos(self.theta)}

    def __repr__(self) -> str:
        return f"omega_{self.name}"


wm, wo, wi = Direction("m"), Direction("o"), Direction("i")


class chi(sp.Function):
    """The Heaviside function of the field: 1 for a positive argument, otherwise 0."""

    @classmethod
    def eval(cls, argument: sp.Expr) -> sp.Expr | None:
        if argument.is_positive:
            return sp.Integer(1)
        return sp.Integer(0) if argument.is_nonpositive else None

    def _latex(self, printer: Any) -> str:
        return rf"\chi^{{+}}\left( {printer.doprint(self.args[0])} \right)"


def latex(expression: Any) -> str:
    """LaTeX of an expression in the author's order, in the field's symbols."""
    names = {**LATEX, **{d.symbol: rf"\omega_{d.name}" for d in (wm, wo, wi)}}
    printer = _Printer({"order": "none", "symbol_names": names, "ln_notation": True})
    return str(printer.doprint(_flat(sp.sympify(expression))))


class _Printer(LatexPrinter):
    """sympy's LaTeX with the field's habits: cos^4 theta without brackets, exp of a fraction on the line."""

    def _trigonometric(self, name: str, argument: sp.Expr, power: str | None) -> str:
        raised = f"^{{{power}}}" if power else ""
        inside = self.doprint(argument)
        return rf"\{name}{raised} {inside} " if argument.is_Symbol else rf"\{name}{raised} \left( {inside} \right)"

    def _print_sin(self, e: sp.Expr, exp: str | None = None) -> str:
        return self._trigonometric("sin", e.args[0], exp)

    def _print_cos(self, e: sp.Expr, exp: str | None = None) -> str:
        return self._trigonometric("cos", e.args[0], exp)

    def _print_tan(self, e: sp.Expr, exp: str | None = None) -> str:
        return self._trigonometric("tan", e.args[0], exp)

    def _print_cot(self, e: sp.Expr, exp: str | None = None) -> str:
        return self._trigonometric("cot", e.args[0], exp)

    def _print_Mul(self, e: sp.Mul) -> str:
        """An integral, and a factor too tall for one line, stands behind the fraction and not on it."""
        tall = [f for f in e.args if _is_tall(f)]
        rest = [f for f in e.args if f not in tall]
        below = [f for f in rest if _is_below(f)]
        if not tall or not below or any(f.is_Pow and _has_fraction(f.base) for f in below):
            return str(super()._print_Mul(e))
        front = self.doprint(sp.Mul(*rest, evaluate=False) if len(rest) > 1 else rest[0])
        return " ".join([front, *(rf"\left( {self.doprint(f)} \right)" if f.is_Add else self.doprint(f) for f in tall)])

    def _extremum(self, name: str, e: sp.Expr) -> str:
        """Numbers first, then what belongs to the view, then what belongs to the light."""
        inside = sorted(map(self.doprint, e.args), key=lambda text: (len(text) > 3, r"\omega_i" in text, text))
        return rf"\{name} \left( {', '.join(inside)} \right)"

    def _print_Max(self, e: sp.Expr, exp: str | None = None) -> str:
        return self._extremum("max", e)

    def _print_Min(self, e: sp.Expr, exp: str | None = None) -> str:
        return self._extremum("min", e)

    def _print_exp(self, e: sp.Expr, exp: str | None = None) -> str:
        inside = self.doprint(e.args[0])
        return rf"\exp \left( {inside} \right)" if "\\frac" in inside or "\\tan" in inside else f"e^{{{inside}}}"

    def _print_Integral(self, e: sp.Integral) -> str:
        text = str(super()._print_Integral(e)).replace(r"\int\limits", r"\int")
        return rf"{text} "

    def _print_Function(self, e: sp.Expr, exp: str | None = None) -> str:
        if isinstance(e, AppliedUndef):
            name, inside = FUNCTIONS.get(e.func.__name__, e.func.__name__), ", ".join(map(self.doprint, e.args))
            bracketed = rf"\left( {inside} \right)" if "\\frac" in inside else f"({inside})"
            return name + bracketed + (f"^{{{exp}}}" if exp else "")
        name = _ROMAN.get(e.func.__name__, e.func.__name__)
        return rf"\mathrm{{{name}}}{f'^{{{exp}}}' if exp else ''}\left( {', '.join(map(self.doprint, e.args))} \right)"

    def _print_expint(self, e: sp.Expr, exp: str | None = None) -> str:
        return rf"E_{{{self.doprint(e.args[0])}}}\left( {self.doprint(e.args[1])} \right)"

    def _print_hyper(self, e: sp.Expr, exp: str | None = None) -> str:
        above, below, argument = (", ".join(map(self.doprint, part)) for part in (e.ap, e.bq, [e.argument]))
        return rf"{{}}_2F_1\left( {above}; {below}; {argument} \right)"

    _print_erf = _print_erfc = _print_asinh = _print_atanh = _print_asin = _print_acos = _print_atan = _print_Function


_ROMAN = {"atanh": "artanh", "asinh": "arsinh", "atan": "arctan", "asin": "arcsin", "acos": "arccos"}


def _is_below(e: sp.Expr) -> bool:
    """Whether the factor is printed below a fraction's bar."""
    return bool((e.is_Rational and e.q != 1) or (e.is_Pow and e.exp.is_Number and e.exp.is_negative))


def _has_fraction(e: sp.Expr) -> bool:
    """Whether the expression prints with a fraction, other than in an exponent."""
    return _is_below(e) or any(_has_fraction(f) for f in ([e.base] if e.is_Pow else e.args))


def _is_tall(e: sp.Expr) -> bool:
    """Whether the factor is too tall to stand on a fraction: an integral, or what itself holds a fraction."""
    if isinstance(e, sp.Integral):
        return True
    inside = [e.base] if e.is_Pow and e.exp.is_positive else e.args if e.is_Add or isinstance(e, sp.Function) else ()
    return any(map(_has_fraction, inside))


def _flat(e: sp.Basic) -> sp.Basic:
    """Sums of sums and products of products written as one, without factors 1: as an author writes them."""
    if isinstance(e, sp.Rational) and e.q > 8 and 10**5 % e.q == 0:
        return sp.Symbol(str(e.p / e.q))  # a measured number, printed as it was published
    if not e.args:
        return e
    args = [_flat(argument) for argument in e.args]
    if isinstance(e, sp.Add | sp.Mul):
        args = [inner for arg in args for inner in (arg.args if isinstance(arg, type(e)) else (arg,))]
        if isinstance(e, sp.Mul):
            args = [arg for arg in args if arg != 1] or [sp.Integer(1)]
        return args[0] if len(args) == 1 else e.func(*args, evaluate=False)
    if isinstance(e, sp.Pow):
        return sp.Pow(*args, evaluate=False)
    return e.func(*args, evaluate=False) if isinstance(e, sp.Abs) else e.func(*args)


def printed_symbol(name: str, printed: str, **assumptions: Any) -> sp.Symbol:
    """A symbol for a left-hand side or a value that the report prints in its own way."""
    symbol = sp.Symbol(name, **assumptions)
    LATEX[symbol] = printed
    return symbol
