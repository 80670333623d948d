"""An equation is stated once: its print, its 50-digit reference, its kernel and its checks come from one statement."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from types import FunctionType
from typing import Any

import mpmath
import sympy as sp

from microfacet.compiler.batch import Batch
from microfacet.compiler.kernels import packed
from microfacet.directions import numbers
from microfacet.statements import enclosures
from microfacet.statements.code import generate
from microfacet.statements.notation import Direction, latex
from microfacet.statements.reference import reference
from microfacet.statements.registry import STAGES, load, refuse_misplaced, registry

Interval = tuple[Any, Any]
Ulps = tuple[float, float]


@dataclass(frozen=True, eq=False)
class Equation:
    r"""A statement: an equation, its proof, its kernel, and the domain and accuracy it promises.

    Parameters
    ----------
    key : str
        Dotted name; the first word is the folder of the library that it stands in.
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
    >>> statement = mf.equations["geometry.ggx.Lambda"]
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
    enclosed: Callable[[Any], Sequence[enclosures.Enclosure]] | tuple[str, ...] = ()
    slides: tuple[int, ...] = ()
    cite: str = ""
    note: str = ""
    stated_at: str = field(init=False, default="")

    def __post_init__(self) -> None:
        frame = sys._getframe(2)  # who wrote Equation(...): one frame above the generated __init__
        object.__setattr__(self, "stated_at", f"{frame.f_globals['__name__']}, line {frame.f_lineno}")
        refuse_misplaced(frame.f_globals["__name__"], self.key)
        if self.means is None and self.equals is None:
            raise ValueError(f"equation {self.key} states nothing: give means or equals")
        registry.add(self)

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

    @property
    def computed_latex(self) -> str:
        """LaTeX of the form that is evaluated, which keeps its digits: symbol = rewritten closed form, if there is one."""
        return f"{latex(self.symbol)} {self.relation} {latex(self.computed)}"

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
        ValueError
            For another number of arguments.
        ArithmeticError
            If 50 digits cannot be had.

        Examples
        --------
        >>> import microfacet as mf
        >>> print(mf.equations["geometry.ggx.Lambda"].exact(2.0))
        0.0590169943749474
        """
        self._refuse_another_number(arguments)
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
        >>> print(f"{mf.equations['geometry.ggx.Lambda'].kernel(2.0):.12f}")
        0.059016994375
        """
        self._refuse_another_number(arguments)
        return self._batch([numbers(str(s), given).array for s, given in zip(self.arguments, arguments, strict=True)])

    def _refuse_another_number(self, arguments: tuple[Any, ...]) -> None:
        if len(arguments) != len(self.arguments):
            raise ValueError(f"{self.key} takes {len(self.arguments)} arguments {self.arguments}, got {len(arguments)}")

    # --- check ------------------------------------------------------------------------------------------------

    def check(self) -> Any:
        """Prove the statement, and compare its kernel with the exact value over the whole domain.

        Returns
        -------
        microfacet.statements.checks.StatementRecord
            What was found, by kind of check.

        Examples
        --------
        >>> import microfacet as mf
        >>> mf.equations["visibility.implicit.G1"].check().verdict
        'pass'
        """
        from microfacet.statements.checks import check as find_out

        return find_out(self)


def _printed_width(text: str) -> int:
    """Roughly how many letters wide a formula prints: commands count as one."""
    return len(re.sub(r"\\(left|right|frac|cdot|,)|[{}\s^_]", "", re.sub(r"\\[a-z]{3,}", "x", text)))


# --- the collection ----------------------------------------------------------------------------------------------------


def _place(key: str) -> tuple[int, str]:
    stage = key.partition(".")[0]
    return STAGES.index(stage) if stage in STAGES else len(STAGES), key


class Equations(Mapping[str, Equation]):
    """All statements of the library, a mapping from their keys to `Equation`, in the order of the talk, then by name.

    ``mf.equations`` is the one object of this class.

    Examples
    --------
    >>> import microfacet as mf
    >>> mf.equations["geometry.ggx.Lambda"].title
    "Smith's Lambda for GGX"
    """

    def _load(self) -> dict[str, Equation]:
        load()
        return registry.statements

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


equations = Equations()
