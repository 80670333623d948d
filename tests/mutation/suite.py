"""Breaks every statement and every kernel in every way of mutants.py, one at a time, and asks which check goes red.

`python tests/mutation/suite.py --out FILE.json` writes the tally, `KEY...` restricts it.
"""

from __future__ import annotations

import argparse
import copy
import itertools
import json
import math
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from fractions import Fraction
from functools import cache
from pathlib import Path
from types import FunctionType
from typing import Any, NamedTuple

import mpmath
import numpy as np
import scene
import sympy as sp
from integrals import integral_differs, stands_for_integrals
from microfacet import arithmetic
from microfacet.geometry import blinn_phong
from microfacet.geometry.ggx import inverse_square
from microfacet.material import fresnel
from microfacet.statements import ball_functions, balls, checks, enclosures
from microfacet.statements.balls import NoBall
from microfacet.statements.registry import registry
from microfacet.statements.statement import Equation, equations
from mutants import called, of_expression, of_kernel, rebound

PARTS = ("means", "equals", "computed_as")
ORIGINAL = {key: equations[key] for key in equations}


TOLD = "mutants"  # the property of a test that holds its outcomes


@dataclass(frozen=True)
class Outcome:
    """One mutant and the check that went red, "equivalent" if it was proved to be none, or nothing."""

    key: str
    part: str
    rule: str
    killed_by: str


@contextmanager
def broken(key: str, **changes: Any) -> Iterator[Equation]:
    """A statement with some of its parts changed, in its own place in the ledger."""
    at, enclosures.at = enclosures.at, one_at_a_time
    try:
        with registry.without(key):
            yield replace(ORIGINAL[key], **changes)
    finally:
        enclosures.at = at


def one_at_a_time(residual: Callable[..., Any], points: Sequence[Mapping[str, Any]]) -> Iterator[enclosures.Enclosure]:
    """balls.at for who may stop at the first ball that is off."""
    for point in points:
        with balls.precision(enclosures.ENCLOSING):
            found = enclosures.Enclosure(enclosures.named(point), residual(**{k: balls.ball(v) for k, v in point.items()}))
        yield found


# --- checks, the cheapest first -------------------------------------------------------------------------------------------


def forms(it: Equation) -> bool:
    """The numeric mark: the forms of the statement are not the same number."""
    return bool(it.over) and bool(checks.forms_disagree(it))


def kernel(it: Equation) -> bool:
    """The numeric mark: the kernel, which stayed, is not the new value; at as many arguments as it takes."""
    if not it.over or it.computed_by is None:
        return False
    points = checks.sample(it, np.float64)
    return any(_off(it.scalar, point, it.exact(*point), it.within[0]) for point in points[:40])


def coarsely(it: Equation) -> bool:
    """The enclosed mark, seen in coarse balls already: if they exclude 0, they do so rightly."""
    if not callable(it.enclosed) or it.relation != "=":
        return False
    fine = enclosures.ENCLOSING, ball_functions.EVALUATIONS
    enclosures.ENCLOSING, ball_functions.EVALUATIONS = 64, 1000
    try:
        return any(e.residual.is_finite() and not e.residual.contains(0) for e in itertools.islice(it.enclosed(it), 4))
    finally:
        enclosures.ENCLOSING, ball_functions.EVALUATIONS = fine


def quadrature(it: Equation) -> bool:
    """test_ledger's: the closed form is the integral it stands for."""
    return stands_for_integrals(ORIGINAL[it.key]) and bool(integral_differs(it, 1, 15))


def in_scene(it: Equation) -> bool:
    """test_scene's: every symbol a number, left and right are the same."""
    return bool(scene.wrong(it))


def enclosed(it: Equation) -> bool:
    if not callable(it.enclosed):
        return checks.enclosed(it).status == "fail"
    return any(not e.supports(it.relation) for e in it.enclosed(it))


def symbolic(it: Equation) -> bool:
    """A claim that the statement itself makes cannot be proved; proofs that do not look at it say nothing of it.

    Differences of integrals are left to quadrature: sympy may look for antiderivatives for hours.
    """
    proofs = {name: getattr(it, name) for name in ("proof", "rewrite_proof")}
    blind = [name for name, proof in proofs.items() if proof is not None and not checks.takes_statement(proof)]
    claims = checks._claims(replace_quietly(it, dict.fromkeys(blind, list)))
    return any(not checks.vanishes(claim) for _, claim in claims if not sp.sympify(claim).has(sp.Integral))


def replace_quietly(it: Equation, changes: dict[str, Any]) -> Equation:
    """The same statement with other parts, which the ledger does not get to know."""
    changed = copy.copy(it)
    for name, value in changes.items():
        object.__setattr__(changed, name, value)
    return changed


CHECKS: dict[str, Callable[[Equation], bool]] = {
    "numeric": lambda it: forms(it) or kernel(it),
    "scene": in_scene,
    "enclosed": coarsely,
    "quadrature": quadrature,
    "enclosed in full": enclosed,
    "symbolic": symbolic,
}
REFUSALS = (ArithmeticError, ValueError, NoBall)  # a check that cannot be carried out is red as well


def red(it: Equation) -> str:
    """The name of a check that fails, or nothing."""
    for name, fails in CHECKS.items():
        try:
            if fails(it):
                return name
        except REFUSALS:
            return name
    return ""


# --- statements -----------------------------------------------------------------------------------------------------------


def outcomes_of_statement(key: str) -> Iterator[Outcome]:
    for part in PARTS:
        form = getattr(ORIGINAL[key], part)
        for mutant in of_expression(form) if form is not None else ():
            with broken(key, **{part: mutant.made}) as it:
                killer = red(it)
            yield Outcome(key, part, mutant.rule, killer or equivalent(ORIGINAL[key], form, mutant.made))


def equivalent(it: Equation, form: Any, made: Any) -> str:
    """ "equivalent" if sympy proves that nothing has changed; of an integral from -c to c the odd part does not count."""
    before, after = (_open(part, it.where).doit() for part in (form, made))
    return "equivalent" if before == after or checks.vanishes(before - after) else ""


def _open(form: Any, where: Mapping[Any, Any]) -> Any:
    """Integrals as their integrands, times a symbol of their limits: forms that are linear in them are equal if these are."""
    return sp.sympify(form).replace(lambda e: isinstance(e, sp.Integral), lambda e: _integrand(e, where))


def _integrand(e: sp.Integral, where: Mapping[Any, Any]) -> Any:
    """What counts of it: from -c to c the even part, over the whole plane the part that does not tell the axes apart."""
    inside, limits = e.function.subs(where), e.limits
    if len(limits) == 1 and limits[0][1] == -limits[0][2]:
        inside = inside + inside.subs(limits[0][0], -limits[0][0])
    if len(limits) == 2 and limits[0][1:] == limits[1][1:]:
        inside = inside + inside.subs({limits[0][0]: limits[1][0], limits[1][0]: limits[0][0]}, simultaneous=True)
    return inside * sp.Symbol(f"over {limits}", positive=True)


# --- kernels --------------------------------------------------------------------------------------------------------------


def computed() -> list[str]:
    return [key for key, it in ORIGINAL.items() if checks.is_computed(it)]


@cache
def users() -> dict[FunctionType, list[str]]:
    """For each kernel the statements that it helps to compute."""
    found: dict[FunctionType, list[str]] = {}
    for key in computed():
        for function in called(ORIGINAL[key].scalar):
            found.setdefault(function, []).append(key)
    return found


def outcomes_of_kernel(function: FunctionType) -> Iterator[Outcome]:
    keys = users()[function]
    for mutant in of_kernel(function):
        killer = any(wrong_kernel(key, rebound(ORIGINAL[key].scalar, function, mutant.made)) for key in keys)
        red = "numeric" if killer else known_values(function, mutant.made) or _symmetric(keys, mutant.rule)
        if not red and mutant.rule.endswith(" swapped") and _alike(function, mutant.made):
            red = "equivalent"
        yield Outcome(keys[0], f"kernel {function.__name__}", mutant.rule, red)


def known_values(function: FunctionType, made: FunctionType) -> str:
    """Where a statement promises several ulps, or does not come near the points at which a kernel's care shows: the inverse of
    a square is known to half an ulp, what test_fresnel and test_distributions look at to a few."""
    if function is inverse_square and abs(Fraction(made(0.1)[1]) * Fraction(0.1) ** 2 - 1) > Fraction(0.51 * 2**-52):
        return "known values"
    return "known values" if any(known.differs(rebound(known.kernel, function, made)) for known in KNOWN[function]) else ""


class Known(NamedTuple):
    """A kernel, what it should give at 50 digits, hard arguments, and how many ulps it may be off there."""

    kernel: FunctionType
    exact: Callable[..., Any]
    points: list[tuple[float, ...]]
    within: float

    def differs(self, kernel: Callable[..., float]) -> bool:
        return any(self._off(kernel, point) for point in self.points)

    def _off(self, kernel: Callable[..., float], point: tuple[float, ...]) -> bool:
        with mpmath.workdps(50):
            exact = self.exact(*map(mpmath.mpf, point))
            return not abs(_run(kernel, np.array(point)) - exact) <= self.within * 2.0**-52 * abs(exact)


def _beside_the_zero() -> list[tuple[float, ...]]:
    """Cosines next to the one beyond which light is reflected totally."""
    roots = [(eta, kappa, math.sqrt(1 + kappa**2 - eta**2)) for eta in (0.3, 0.55, 0.7, 0.9) for kappa in (0.0, 0.1, 0.37)]
    return [(root * (1 + d), eta, kappa) for eta, kappa, root in roots for d in (3e-15, -7e-15, 1e-12, -1e-6, 0.1)]


def _reflectance(cosine: Any, eta: Any, kappa: Any) -> Any:
    """By complex amplitudes."""
    index = eta + 1j * kappa
    g = mpmath.sqrt(index**2 - 1 + cosine**2)
    across, along = (cosine - g) / (cosine + g), (index**2 * cosine - g) / (index**2 * cosine + g)
    return (abs(across) ** 2 + abs(along) ** 2) / 2


BEYOND = Known(fresnel.beyond_critical, lambda c, e, k: c**2 - 1 + e**2 - k**2, _beside_the_zero(), 2)
CONDUCTOR = Known(
    fresnel.conductor,
    _reflectance,
    [(c, 1 + d, k) for c in (0.05, 0.4, 0.9) for d in (-1e-3, 1e-9, 1e-5, 0.2, 3.0) for k in (0.0, 1e-7, 1e-3, 0.5, 1e3)],
    8,
)
POWER = Known(
    arithmetic.inverse_power,
    lambda t, rest, power: (1 + t + rest) ** -power,
    [
        *((t, t * rest, n / t) for t in (1e-9, 1e-4, 0.3, 0.7) for rest in (-0.9e-16, 0.0, 0.8e-16) for n in (0.1, 3.3, 40.0)),
        *((t, 0.0, 4e17) for t in (0.7e-16, 1.05e-16, 2.9e-16, 3.2e-16, 5.3e-16)),  # where what is left of 1 + t counts most
    ],
    8,
)
STUDENT = Known(
    blinn_phong.student_Lambda,
    lambda c, n, K: ORIGINAL["geometry.blinn_phong.Lambda"].exact(c, n, K),
    [(c, n, 1.0) for c in (30.0, 1e3) for n in (2 - 2.0**-52, 16 - 2.0**-49)],  # where n + 1 is rounded
    8,
)
KNOWN: dict[Any, list[Known]] = defaultdict(list)
for _known in (BEYOND, CONDUCTOR, POWER, STUDENT):
    for _function in called(_known.kernel):
        KNOWN[_function].append(_known)


def _alike(function: FunctionType, made: FunctionType) -> bool:
    """Whether swapped arguments change nothing but the order of sums, seen at many points."""
    points = np.random.default_rng(0).uniform(0.1, 2, (500, function.__code__.co_argcount))
    return all(np.allclose(function(*map(float, point)), made(*map(float, point)), rtol=1e-12, atol=0) for point in points)


def _symmetric(keys: list[str], rule: str) -> str:
    """A kernel generated from a form that sympy proves to be symmetric does not change if these arguments are swapped."""
    first, _, second = rule.partition(" and ")
    it = ORIGINAL[keys[0]]
    pair = [s for s in it.arguments if str(s) in (first, second.removesuffix(" swapped"))]
    if it.computed_by is not None or len(pair) != 2 or len(keys) != 1:
        return ""
    form, exchange = sp.sympify(it.computed), dict(zip(pair, pair[::-1], strict=True))
    return "equivalent" if checks.vanishes(form - form.subs(exchange, simultaneous=True)) else ""


def wrong_kernel(key: str, scalar: Callable[..., float]) -> bool:
    """The numeric mark: some value is farther off than promised."""
    it = ORIGINAL[key]
    points = _points(key)
    return any(_off(scalar, points[k], _exact(key, k), it.within[0]) for k in range(len(points)))


def _off(scalar: Callable[..., float], point: np.ndarray, exact: Any, promise: float) -> bool:
    if not checks.representable(exact, np.float64):
        return False
    return not checks.ulps(_run(scalar, point), exact, np.float64) <= promise


def _run(scalar: Callable[..., float], point: np.ndarray) -> float:
    """As a compiled loop would: what Python refuses is no number there."""
    try:
        value = scalar(*map(float, point))
    except (ArithmeticError, ValueError, IndexError):
        return math.nan
    return value if isinstance(value, float) else math.nan


@cache
def _points(key: str) -> np.ndarray:
    """The arguments of the numeric check at which Python does what a compiled loop does."""
    it = ORIGINAL[key]
    return np.array([p for p in checks.sample(it, np.float64) if math.isfinite(_run(it.scalar, p))])


@cache
def _exact(key: str, k: int) -> Any:
    return ORIGINAL[key].exact(*_points(key)[k])


# --- tally ----------------------------------------------------------------------------------------------------------------


def tally(outcomes: list[Outcome]) -> dict[str, Any]:
    """How many mutants there were, and how many each check killed. Proved equivalents are no mutants."""
    real = [o for o in outcomes if o.killed_by != "equivalent"]
    return {
        "mutants": len(real),
        "killed by": dict(Counter(o.killed_by for o in real if o.killed_by)),
        "survived": [asdict(o) for o in real if not o.killed_by],
        "equivalent": len(outcomes) - len(real),
    }


def said(outcomes: Iterable[Outcome]) -> str:
    """The tally in a sentence."""
    report = tally(list(outcomes))
    killed = ", ".join(f"{count} by {name}" for name, count in sorted(report["killed by"].items()))
    survived, equivalent = len(report["survived"]), report["equivalent"]
    return f"{report['mutants']} mutants: {killed}; {survived} survived; {equivalent} proved equivalent"


def main() -> None:
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("keys", nargs="*", metavar="KEY", help="statements to break; none means all, and all kernels")
    words.add_argument("--out", type=Path, metavar="FILE", help="write the tally here")
    chosen = words.parse_args()
    found: list[Outcome] = []
    for key in chosen.keys or ORIGINAL:
        found += _told(key, outcomes_of_statement(key))
    for function in [] if chosen.keys else users():
        found += _told(function.__name__, outcomes_of_kernel(function))
    report = tally(found)
    if chosen.out:
        chosen.out.write_text(json.dumps(report, indent=1) + "\n")
    for o in report["survived"]:
        print(o["key"], "|", o["part"], "|", o["rule"])
    print({**report, "survived": len(report["survived"])})


def _told(name: str, outcomes: Iterator[Outcome]) -> list[Outcome]:
    start = time.process_time()
    found = list(outcomes)
    print(f"{time.process_time() - start:6.1f} s  {name}: {dict(Counter(o.killed_by for o in found))}", flush=True)
    return found


if __name__ == "__main__":
    main()
