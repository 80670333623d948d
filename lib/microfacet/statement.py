"""An equation is stated once: its print, its 50-digit reference, its kernel and its checks come from one statement."""

from __future__ import annotations

import functools
import hashlib
import importlib
import inspect
import math
import pkgutil
import re
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass
from functools import cache, cached_property
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any

import mpmath
import sympy as sp
from sympy.core.function import AppliedUndef

from microfacet import balls
from microfacet.arithmetic import exp_minus_square
from microfacet.directions import numbers
from microfacet.kernels import Batch, packed, source
from microfacet.notation import Direction, chi, latex

DIGITS = balls.DIGITS
Interval = tuple[Any, Any]
Ulps = tuple[float, float]


@dataclass(frozen=True, eq=False)
class Equation:
    r"""A statement: an equation, its proof, its kernel, and the domain and accuracy it promises.

    Parameters
    ----------
    key : str
        Dotted name, stage first.
    title : str
        What it states, in words.
    symbol : sympy expression
        The left-hand side.
    means : sympy expression, optional
        The definition.
    equals : sympy expression, optional
        The closed form.
    computed_as : sympy expression, optional
        The closed form rewritten so that it keeps its digits.
    computed_by : callable, optional
        A kernel written by hand, where no rewriting suffices; tested against the exact value all the same.
    over : mapping, optional
        The arguments in order: a symbol with its interval, or a Direction with ``"hemisphere"`` or ``"sphere"``.
    within : pair of float, optional
        Promised error of the kernel in ulps, in double and in single precision.
    where : mapping, optional
        What arguments, and symbols that other statements define, stand for in printed symbols.
    relation : str, optional
        ``"="`` or, for a bound, ``"<"``, ``">"``, ``r"\le"``, ``r"\ge"`` or ``r"\ne"``; ``r"\approx"`` for a fit.
    proof : callable, optional
        Gives, perhaps from the statement, the expressions that sympy must find to be zero, in place of means - equals.
    rewrite_proof : callable, optional
        Likewise in place of computed_as - equals.
    proved_by : str, optional
        How it is proved, in words.
    enclosed : callable or tuple of str, optional
        From the statement, proved balls that hold its left side minus its right; or the keys of statements that do.
    slides : tuple of int, optional
        Slides of the talk.
    cite : str, optional
        BibTeX key and equation number.
    note : str, optional
        What a reader should know.

    Examples
    --------
    >>> import microfacet as mf
    >>> statement = mf.equations["visibility.ggx.Lambda"]
    >>> print(statement.title, statement.cite, statement.within)
    Smith's Lambda for GGX heitz2014, eq. 72 (8.0, 8.0)
    """

    key: str
    title: str
    symbol: Any
    means: Any = None
    equals: Any = None
    computed_as: Any = None
    computed_by: Callable[..., Any] | None = None
    over: Mapping[Any, Any] = field(default_factory=dict)
    within: Ulps = (8.0, 8.0)
    where: Mapping[Any, Any] = field(default_factory=dict)
    relation: str = "="
    proof: Callable[..., Sequence[Any]] | None = None
    rewrite_proof: Callable[..., Sequence[Any]] | None = None
    proved_by: str = ""
    enclosed: Callable[[Any], Sequence[balls.Enclosure]] | tuple[str, ...] = ()
    slides: tuple[int, ...] = ()
    cite: str = ""
    note: str = ""
    stated_at: str = field(init=False, default="")

    def __post_init__(self) -> None:
        frame = sys._getframe(2)  # who wrote Equation(...): one frame above the generated __init__
        object.__setattr__(self, "stated_at", f"{frame.f_globals['__name__']}, line {frame.f_lineno}")
        _refuse_unread(frame.f_globals["__name__"], self.key)
        if self.key in _registry:
            raise ValueError(f"equation {self.key} is stated twice")
        if self.means is None and self.equals is None:
            raise ValueError(f"equation {self.key} states nothing: give means or equals")
        _registry[self.key] = self
        if isinstance(self.symbol, AppliedUndef):
            _abbreviations[self.symbol.func] = self

    # --- print ------------------------------------------------------------------------------------------------

    @property
    def latex(self) -> str:
        """LaTeX of the statement as the report prints it: symbol = definition = closed form."""
        left, *right = [latex(e) for e in (self.symbol, self.means, self.equals) if e is not None]
        signs = ["="] * (len(right) - 1) + [self.relation]
        width = sum(map(_printed_width, [left, *right]))
        if width - _printed_width(right[-1]) * (len(right) - 1) > 82:  # too wide for what stands beside the left side
            below = "".join(rf" \\ &\quad {s} {r}" for s, r in zip(signs, right, strict=True))
            return rf"\begin{{aligned}} &{left}{below} \end{{aligned}}"
        if len(right) == 1 or width < 62:
            return " ".join([left, *(f"{s} {r}" for s, r in zip(signs, right, strict=True))])
        lines = r" \\ ".join(f"&{s} {r}" for s, r in zip(signs, right, strict=True))
        return rf"\begin{{aligned}} {left} {lines} \end{{aligned}}"

    # --- evaluate ---------------------------------------------------------------------------------------------

    @property
    def arguments(self) -> tuple[sp.Symbol, ...]:
        """The kernel's arguments: directions give their three components."""
        return tuple(s for d in self.over for s in (d.components if isinstance(d, Direction) else (d,)))

    @property
    def computed(self) -> Any:
        """The expression that kernel and reference evaluate."""
        for form in (self.computed_as, self.equals, self.means):
            if form is not None:
                return form
        raise AssertionError

    def exact(self, *arguments: Any) -> mpmath.mpf:
        """Value to 50 digits.

        Parameters
        ----------
        *arguments : float or mpmath.mpf
            Numbers in the order of ``over``, taken as exact; a direction counts as three.

        Returns
        -------
        mpmath.mpf
            Value of the statement's right-hand side.

        Raises
        ------
        ArithmeticError
            If 50 digits cannot be had.

        Examples
        --------
        >>> import microfacet as mf
        >>> print(mf.equations["visibility.ggx.Lambda"].exact(2.0))
        0.0590169943749474
        """
        return self._reference(*arguments)

    @cached_property
    def _reference(self) -> Callable[..., mpmath.mpf]:
        return reference(self.computed, self.arguments)

    @cached_property
    def scalar(self) -> FunctionType:
        """The statement as a Python function of floats: pure, readable, what the compiled loops are made of."""
        if self.computed_by is not None:
            return self.computed_by  # type: ignore[return-value]
        return generate(self.key.replace(".", "_"), self.computed, self.arguments)

    @cached_property
    def _batch(self) -> Batch:
        return Batch(packed(self.scalar, len(self.arguments), 0), [1] * len(self.arguments))

    def kernel(self, *arguments: Any) -> Any:
        """Value over arrays, in double precision or, for float32 arguments, in single.

        Parameters
        ----------
        *arguments : array_like
            Numbers in the order of ``over``; shapes broadcast. A direction counts as three.

        Returns
        -------
        ndarray
            Value of the statement's right-hand side, within the promised error.

        Raises
        ------
        ValueError
            For another number of arguments, and for anything but real numbers.

        Examples
        --------
        >>> import microfacet as mf
        >>> print(f"{mf.equations['visibility.ggx.Lambda'].kernel(2.0):.12f}")
        0.059016994375
        """
        if len(arguments) != len(self.arguments):
            raise ValueError(f"{self.key} takes {len(self.arguments)} arguments {self.arguments}, got {len(arguments)}")
        return self._batch([numbers(str(s), given).array for s, given in zip(self.arguments, arguments, strict=True)])

    # --- check ------------------------------------------------------------------------------------------------

    def check(self) -> Any:
        """Prove the statement, and compare its kernel with the exact value over the whole domain.

        Returns
        -------
        microfacet.checks.StatementRecord
            What was found, by kind of check.

        Examples
        --------
        >>> import microfacet as mf
        >>> mf.equations["visibility.implicit.G1"].check().verdict
        'pass'
        """
        from microfacet.checks import check as find_out

        return find_out(self)

    @property
    def fingerprint(self) -> str:
        """A digest that changes when, and only when, the outcome of the checks may change."""
        return hashlib.sha256("\n".join([_checker(), *_content(self, set())]).encode()).hexdigest()[:20]


def _printed_width(text: str) -> int:
    """Roughly how many letters wide a formula prints: commands count as one."""
    return len(re.sub(r"\\(left|right|frac|cdot|,)|[{}\s^_]", "", re.sub(r"\\[a-z]{3,}", "x", text)))


# --- from expression to reference ---------------------------------------------------------------------------------


def expand_abbreviations(expression: Any) -> Any:
    """Replace every abbreviation that another statement defines by what it stands for."""
    while found := [f for f in sp.sympify(expression).atoms(AppliedUndef) if f.func in _abbreviations]:
        for f in found:
            stated = _abbreviations[f.func]
            form = stated.equals if stated.equals is not None else stated.means
            expression = expression.subs(f, form.subs(dict(zip(stated.symbol.args, f.args, strict=True)), simultaneous=True))
    return expression


def stands_for(function: Any) -> tuple[tuple[Any, ...], Any] | None:
    """What an abbreviation that another statement defines takes and stands for."""
    if function not in _abbreviations:
        return None
    stated = _abbreviations[function]
    return stated.symbol.args, stated.equals if stated.equals is not None else stated.means


def reference(expression: Any, arguments: Sequence[sp.Symbol]) -> Callable[..., mpmath.mpf]:
    """A function that gives the expression to 50 digits: proved in ball arithmetic where python-flint is installed."""
    if balls.available():
        try:
            return balls.exact(expression, arguments)
        except balls.NoBall:
            pass
    return multiprecision(expression, arguments)


def multiprecision(expression: Any, arguments: Sequence[sp.Symbol]) -> Callable[..., mpmath.mpf]:
    """The expression to 50 digits with mpmath alone: the working precision doubles until two agree.

    It begins at 400 digits: a value that a double can hold has lost at most some 330 of them to cancellation.
    """
    translate = {"chi": lambda value: mpmath.mpf(1 if value > 0 else 0)}
    function = sp.lambdify(arguments, expand_abbreviations(expression), modules=[translate, "mpmath"])

    def evaluate(*values: Any) -> mpmath.mpf:
        exact = [mpmath.mpf(float(v)) if not isinstance(v, mpmath.mpf) else v for v in values]
        before, digits = None, 400
        while digits <= 6400:
            with mpmath.workdps(digits):
                now = mpmath.mpf(function(*exact))
                if before is not None and abs(now - before) <= abs(now) * mpmath.mpf(10) ** -DIGITS:
                    return now
            before, digits = now, 2 * digits
        raise ArithmeticError(f"no {DIGITS} digits of {expression} at {values}")

    return evaluate


# --- from expression to kernel ------------------------------------------------------------------------------------

_FUNCTIONS: dict[Any, str] = {
    sp.log: "log",
    sp.sin: "sin",
    sp.cos: "cos",
    sp.tan: "tan",
    sp.erf: "erf",
    sp.erfc: "erfc",
    sp.Abs: "abs",
    sp.Max: "max",
    sp.Min: "min",
    sp.atanh: "atanh",
    sp.asinh: "asinh",
}


def generate(name: str, expression: Any, arguments: Sequence[sp.Symbol]) -> FunctionType:
    """A Python function of floats that evaluates the expression as it is written."""
    scope: dict[str, Any] = {f: getattr(math, f) for f in ("sqrt", "exp", *_FUNCTIONS.values()) if hasattr(math, f)}
    text = f"def {name}({', '.join(map(str, arguments))}):\n    return {_code(sp.sympify(expression), scope)}\n"
    exec(text, scope)
    function: FunctionType = scope[name]
    function.__source__ = text  # type: ignore[attr-defined]
    return function


def _code(e: Any, scope: dict[str, Any]) -> str:
    """Python text of an expression; operations are kept in the order in which they were written."""
    if e.is_Symbol:
        return str(e)
    if e.is_Number or e.is_NumberSymbol:
        return f"({e.p}.0 / {e.q}.0)" if e.is_Rational and e.q != 1 else _decimal(e)
    for kind, writer in ((sp.Add, _sum), (sp.Mul, _product), (sp.Pow, _power)):
        if isinstance(e, kind):
            return writer(e, scope)
    return _call(e, scope)


def _sum(e: Any, scope: dict[str, Any]) -> str:
    return "(" + " + ".join(_code(term, scope) for term in e.args) + ")"


def _call(e: Any, scope: dict[str, Any]) -> str:
    inside = [_code(argument, scope) for argument in e.args]
    if isinstance(e, chi):
        return f"(1.0 if {inside[0]} > 0.0 else 0.0)"
    if isinstance(e, sp.exp):
        return _exponential(e.args[0], scope)
    if isinstance(e, AppliedUndef) and e.func in _abbreviations:
        called = _abbreviations[e.func].scalar
        scope[called.__name__] = called
        return f"{called.__name__}({', '.join(inside)})"
    if e.func in _FUNCTIONS:
        return f"{_FUNCTIONS[e.func]}({', '.join(inside)})"
    raise TypeError(f"a kernel cannot evaluate {e.func.__name__} in {e}")


def _exponential(exponent: Any, scope: dict[str, Any]) -> str:
    """exp(-a^2) has a kernel of its own, because rounding the square costs a^2/2 ulps."""
    square = -exponent
    if square.is_Pow and square.base.is_Symbol and square.exp == 2:
        scope["exp_minus_square"] = exp_minus_square
        return f"exp_minus_square({_code(square.base, scope)})"
    return f"exp({_code(exponent, scope)})"


def _decimal(number: Any) -> str:
    text = repr(float(number))
    return f"({text})" if text.startswith("-") else text


def _product(e: Any, scope: dict[str, Any]) -> str:
    below = [f for f in e.args if f.is_Pow and f.exp.is_Number and f.exp.is_negative]
    above = [f for f in e.args if f not in below]
    top = " * ".join(_code(f, scope) for f in above) or "1.0"
    bottom = " * ".join(_code(sp.Pow(f.base, -f.exp, evaluate=False) if f.exp != -1 else f.base, scope) for f in below)
    return f"({top})" if not below else f"({top} / ({bottom}))"


def _power(e: Any, scope: dict[str, Any]) -> str:
    base = _code(e.base, scope)
    if e.base == sp.E:
        return _exponential(e.exp, scope)
    if e.exp.is_Integer and 1 <= e.exp <= 8:
        return "(" + " * ".join([base] * int(e.exp)) + ")"
    if e.exp == sp.Rational(1, 2):
        return f"sqrt({base})"
    if e.exp.is_Number and e.exp.is_negative:
        return f"(1.0 / {_code(sp.Pow(e.base, -e.exp, evaluate=False) if e.exp != -1 else e.base, scope)})"
    return f"({base} ** {_code(e.exp, scope)})"


# --- the collection -----------------------------------------------------------------------------------------------

_registry: dict[str, Equation] = {}
_abbreviations: dict[Any, Equation] = {}


FOLDERS = ("geometry", "visibility", "material", "brdf", "validation")  # of the library, that hold statements
STAGES = (*FOLDERS[:-1], "anisotropy", FOLDERS[-1])  # of the talk, the first words of keys; those of others come after


@cache
def load() -> None:
    """Import every module that may hold statements."""
    for folder in FOLDERS:
        package = importlib.import_module(f"microfacet.{folder}")
        for module in pkgutil.iter_modules(package.__path__):
            importlib.import_module(f"{package.__name__}.{module.name}")


def _refuse_unread(module: str, key: str) -> None:
    """ValueError for a statement in a folder that `load` passes over: it would be there or not, as other imports have it."""
    library, folder, *rest = [*module.split("."), "", ""]
    if library == "microfacet" and rest[0] and folder not in FOLDERS:
        raise ValueError(f"equation {key} stands in {folder}/, where none is looked for, but in {', '.join(FOLDERS)}")


def _place(key: str) -> tuple[int, str]:
    stage = key.partition(".")[0]
    return (STAGES.index(stage), "") if stage in STAGES else (len(STAGES), stage)


class Equations(Mapping[str, Equation]):
    """All statements of the library, a mapping from their keys to `Equation`, in the order of the talk, then by name.

    ``mf.equations`` is the one object of this class.

    Examples
    --------
    >>> import microfacet as mf
    >>> mf.equations["visibility.ggx.Lambda"].title
    "Smith's Lambda for GGX"
    """

    def _load(self) -> dict[str, Equation]:
        load()
        return _registry

    def __getitem__(self, key: str) -> Equation:
        found = self._load()
        if not isinstance(key, str):
            raise KeyError(f"no equation {key!r}: a key is text such as geometry.ggx.D")
        if key not in found:
            import difflib

            near = difflib.get_close_matches(key, found, n=3, cutoff=0.4)
            raise KeyError(f"no equation {key!r}" + (f"; near: {', '.join(near)}" if near else ""))
        return found[key]

    def __iter__(self) -> Iterator[str]:
        return iter(sorted(self._load(), key=_place))

    def __len__(self) -> int:
        return len(self._load())

    def fingerprints(self) -> dict[str, str]:
        """Digests of all statements, each of which changes when the outcome of its checks may change.

        Returns
        -------
        dict of str to str
            A digest for each key.

        Examples
        --------
        >>> import microfacet as mf
        >>> len(mf.equations.fingerprints()) == len(mf.equations)
        True
        """
        return {key: self[key].fingerprint for key in self}


equations = Equations()


@cache
def _checker() -> str:
    """The text of what carries out the checks, and the versions of what it relies on."""
    folder = Path(__file__).parent
    texts = [(folder / f"{name}.py").read_text("utf-8") for name in ("statement", "checks", "balls", "kernels", "notation")]
    return "\n".join([*texts, sys.version, *map(_version, ("numpy", "numba", "sympy", "mpmath", "python-flint"))])


def _version(name: str) -> str:
    try:
        return f"{name} {version(name)}"
    except PackageNotFoundError:
        return f"no {name}"


def _content(thing: Any, seen: set[int]) -> list[str]:
    """Everything that the outcome of a check depends on, as text."""
    if id(thing) in seen:
        return []
    seen.add(id(thing))
    if isinstance(thing, Equation):
        return _equation_content(thing, seen)
    if isinstance(thing, functools._lru_cache_wrapper):
        thing = thing.__wrapped__
        return [_text(thing, inspect.getsource), *_all_content(_uses(thing), seen)]
    if isinstance(thing, FunctionType):
        return [_text(thing, source), *_all_content(_uses(thing), seen)]
    if is_dataclass(thing) and not isinstance(thing, type):
        return [line for part in fields(thing) for line in _content(getattr(thing, part.name), seen)]
    if isinstance(thing, list | tuple | dict):
        parts = [*thing.values()] if isinstance(thing, dict) else [*thing]
        return [repr(thing) if all(isinstance(p, str | float | int) for p in parts) else "", *_all_content(parts, seen)]
    if isinstance(thing, sp.Basic):
        called = [_abbreviations[f.func] for f in thing.atoms(AppliedUndef) if f.func in _abbreviations]
        return [_representation(thing), *(line for e in sorted(called, key=lambda e: e.key) for line in _content(e, seen))]
    return [repr(thing) if isinstance(thing, int | float | str) else repr(getattr(thing, "_fields", ""))]  # of a named tuple


@cache
def _text(function: FunctionType, look_up: Callable[[FunctionType], str]) -> str:
    return look_up(function)


@cache
def _representation(expression: Any) -> str:
    return str(sp.srepr(expression))


def _all_content(things: Sequence[Any], seen: set[int]) -> list[str]:
    return [line for thing in things for line in _content(thing, seen)]


def _uses(function: FunctionType) -> list[Any]:
    """What a function of ours names: globals, what it closes over, and attributes of our modules."""
    root = function.__module__.split(".")[0] if isinstance(function.__module__, str) else ""
    if root in sys.stdlib_module_names or root in ("numpy", "scipy", "sympy", "mpmath", "numba", "flint"):
        return []
    names = sorted(_names(function.__code__))
    found = [function.__globals__[name] for name in names if name in function.__globals__]
    found += [cell.cell_contents for cell in function.__closure__ or ()]
    modules = [m for m in found if isinstance(m, ModuleType) and m.__name__.startswith("microfacet.")]
    return [*found, *(getattr(m, name) for m in modules for name in names if name in vars(m))]


def _names(code: CodeType) -> set[str]:
    """The names in a function's code and in the functions inside it."""
    inner = (_names(constant) for constant in code.co_consts if isinstance(constant, CodeType))
    return set(code.co_names).union(*inner)


def _equation_content(e: Equation, seen: set[int]) -> list[str]:
    lines = [e.key, repr(e.within), e.relation]
    for form in (e.symbol, e.means, e.equals, e.computed_as, *e.where.values(), *e.over.values()):
        lines += _content(form if isinstance(form, tuple | str) else sp.sympify(form), seen)
    for function in (e.proof, e.rewrite_proof, e.computed_by, e.enclosed if callable(e.enclosed) else None):
        lines += _content(function, seen) if function is not None else []
    for key in () if callable(e.enclosed) else e.enclosed:
        lines += _content(_registry[key], seen)
    return [*lines, repr(e.over)]
