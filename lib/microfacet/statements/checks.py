"""The checks of a statement: is it proved, does its kernel keep its digits, and where is it worst?"""

from __future__ import annotations

import inspect
import itertools
import math
import zlib
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

import mpmath
import numpy as np
import sympy as sp

from microfacet.statements import ball_functions, balls, enclosures
from microfacet.statements.notation import Direction
from microfacet.statements.reference import reference
from microfacet.statements.registry import registry, stating
from microfacet.statements.statement import Equation, equations

POINTS = 300  # arguments at which a kernel is compared with 50 digits, in each precision
ROUNDS, WORST, PER_POINT = 5, 8, 6  # of a search for larger errors: in each round, arguments near the worst so far
SAME_LAMBDA = 1e6  # ulps: more than rounding of its argument does to Lambda, and less than any mistake
AGREE = 30  # digits to which two forms of a statement must agree where both have 50


@dataclass
class CheckResult:
    """One kind of check: status is "pass", "fail" or "none" (does not apply); detail describes the result."""

    status: str = "none"
    detail: str = ""
    measured: dict[str, Any] = field(default_factory=dict)


@dataclass
class StatementRecord:
    """The results of the checks of one statement."""

    key: str
    marks: dict[str, CheckResult]
    stated_at: str = ""
    over: str = ""

    @property
    def failures(self) -> list[str]:
        return [f"{kind}: {mark.detail}" for kind, mark in self.marks.items() if mark.status == "fail"]

    @property
    def verdict(self) -> str:
        return "fail" if self.failures else "pass"

    def as_json(self) -> dict[str, Any]:
        message = "" if not self.failures else f"{self.key} ({self.stated_at}): " + "; ".join(self.failures)
        return {**asdict(self), "verdict": self.verdict, "message": message}


def check(equation: Equation) -> StatementRecord:
    """Every check that applies to the statement."""
    marks = {"symbolic": symbolic(equation), "enclosed": enclosed(equation), "numeric": numeric(equation)}
    return StatementRecord(equation.key, marks, equation.stated_at, _domain(equation))


def _domain(equation: Equation) -> str:
    """The domain of the statement, in readable form."""
    return ", ".join(f"{s} on the {d}" if isinstance(d, str) else f"{s} in [{d[0]}, {d[1]}]" for s, d in equation.over.items())


# --- symbolic -------------------------------------------------------------------------------------------------------


def vanishes(expression: Any) -> bool:
    """Whether sympy proves the expression to be zero; it does not try if a value differs from zero."""
    attempts: tuple[Callable[[Any], Any], ...] = (
        lambda e: e,
        _on_circles,
        sp.simplify,
        lambda e: sp.simplify(e.rewrite(sp.erf)),
        lambda e: sp.simplify(sp.radsimp(e)),
        lambda e: sp.simplify(sp.expand(sp.expand_trig(e))),
    )
    value = registry.expand(sp.sympify(expression))
    if disproved(value):
        return False
    value = value.doit()
    return any(attempt(value) == 0 for attempt in attempts)


def disproved(expression: Any) -> bool:
    """Whether the expression is proved to differ from 0 at a random point: its ball there excludes 0."""
    symbols = sorted(expression.free_symbols, key=str)
    if not balls.available() or expression.has(sp.Integral):
        return False
    try:
        value = ball_functions.evaluator(expression, symbols)
    except balls.NoBall:
        return False
    random = np.random.default_rng(0)
    with balls.precision(4 * AGREE):
        for low, high in ((0.1, 0.9), (0.1, 0.9), (1.6, 3.0)):
            ball = value(*map(float, random.uniform(low, high, len(symbols))))
            if ball.is_finite() and not ball.contains(0):
                return True
    return False


def _on_circles(expression: Any) -> Any:
    """Sines and cosines as points on circles: the remainder of the numerator after sin^2 = 1 - cos^2 is substituted."""
    angles = {f.args[0] for f in expression.atoms(sp.sin, sp.cos, sp.tan)}
    if not angles:
        return expression
    pairs = {angle: sp.symbols(f"sin_{k} cos_{k}", cls=sp.Dummy) for k, angle in enumerate(sorted(angles, key=str))}
    for angle, (s, c) in pairs.items():
        expression = expression.subs({sp.tan(angle): s / c, sp.sin(angle): s, sp.cos(angle): c})
    numerator = sp.expand(sp.fraction(sp.together(expression))[0])
    for s, c in pairs.values():
        if not numerator.is_polynomial(s):
            return expression
        numerator = sp.rem(numerator, s**2 + c**2 - 1, s)
    return sp.expand(numerator)


def _claims(equation: Equation) -> Iterable[tuple[str, Any]]:
    """The expressions that must vanish: definition less closed form, closed form less stable rewrite."""
    if equation.proof is not None:
        for k, claim in enumerate(_steps(equation.proof, equation), 1):
            yield f"step {k} of the proof", claim
    elif equation.means is not None and equation.equals is not None and equation.relation == "=":
        yield "closed form = definition", (equation.means - equation.equals).subs(equation.where)
    if equation.rewrite_proof is not None:
        for k, claim in enumerate(_steps(equation.rewrite_proof, equation), 1):
            yield f"step {k} of the rewrite", claim
    elif equation.computed_as is not None:
        stated = equation.equals if equation.equals is not None else equation.means
        yield "stable rewrite = closed form", equation.computed_as.subs(equation.where) - stated.subs(equation.where)


def _steps(proof: Callable[..., Sequence[Any]], equation: Equation) -> Sequence[Any]:
    """The claims of a proof; one that takes an argument is given the statement."""
    return proof(equation) if takes_statement(proof) else proof()


def takes_statement(proof: Callable[..., Any]) -> bool:
    """Whether a proof takes the statement as an argument."""
    return any(parameter.default is parameter.empty for parameter in inspect.signature(proof).parameters.values())


def symbolic(equation: Equation) -> CheckResult:
    """Prove every claim of the statement with sympy."""
    claims = list(_claims(equation))
    failed = [name for name, claim in claims if not vanishes(claim)]
    if failed:
        return CheckResult("fail", f"sympy cannot prove: {', '.join(failed)}")
    if not claims:
        return CheckResult("none", "enclosed only" if equation.enclosed else "a definition")
    detail = equation.proved_by or "sympy: " + ", ".join(name for name, _ in claims)
    scope = "rewriting" if all("rewrite" in name for name, _ in claims) else "definition"
    return CheckResult("pass", detail, {"claims": len(claims), "scope": scope})


# --- enclosed -------------------------------------------------------------------------------------------------------


def enclosed(equation: Equation) -> CheckResult:
    """The enclosure of left side minus right side, by ball arithmetic."""
    if not equation.enclosed:
        return CheckResult("none", "nothing to enclose")
    if not balls.available():
        return CheckResult("none", "python-flint is not installed")
    if not callable(equation.enclosed):
        return _enclosed_elsewhere(equation.enclosed)
    enclosures = list(equation.enclosed(equation))
    broken = [e for e in enclosures if not e.supports(equation.relation)]
    if broken or not enclosures:
        return CheckResult("fail", "; ".join(f"{e.shown} at {e.where}" for e in broken) or "nothing was enclosed")
    return CheckResult("pass", _enclosed_detail(enclosures), _enclosed_figures(enclosures))


def _enclosed_detail(enclosures: Sequence[enclosures.Enclosure]) -> str:
    if len(enclosures) == 1:
        return f"{enclosures[0].shown} for {enclosures[0].where}"
    worst = max(enclosures, key=lambda e: e.radius)
    if worst.residual.contains(0):
        return f"{worst.shown} at {len(enclosures)} points"
    return "; ".join(f"{e.shown} for {e.where}" for e in enclosures)


def _enclosed_figures(enclosures: Sequence[enclosures.Enclosure]) -> dict[str, Any]:
    worst = max(enclosures, key=lambda e: e.radius)
    scope = _common_scope([e.scope for e in enclosures])
    figures: dict[str, Any] = {"radius": worst.radius, "at": worst.where, "count": len(enclosures), "scope": scope}
    if not any(e.residual.contains(0) for e in enclosures):
        figures |= {
            "low": min(float(e.residual.lower()) for e in enclosures),
            "high": max(float(e.residual.upper()) for e in enclosures),
        }
    return figures


def _common_scope(scopes: Sequence[str]) -> str:
    """A statement is enclosed over a range only if each of its parts is."""
    return "range" if set(scopes) == {"range"} else "points"


def _enclosed_elsewhere(keys: Sequence[str]) -> CheckResult:
    """A general statement, through the statements for the single models."""
    marks = {key: enclosed(equations[key]) for key in keys}
    broken = [key for key, mark in marks.items() if mark.status != "pass"]
    if broken:
        return CheckResult("fail", f"not enclosed: {', '.join(broken)}")
    worst = max(marks.values(), key=lambda mark: mark.measured["radius"]).measured
    count = sum(mark.measured["count"] for mark in marks.values())
    detail = f"0 within {worst['radius']:.1e} at {count} points of {len(keys)} models"
    scope = _common_scope([mark.measured["scope"] for mark in marks.values()])
    return CheckResult("pass", detail, {**worst, "count": count, "scope": scope})


# --- numeric --------------------------------------------------------------------------------------------------------


def ulps(value: float, exact: mpmath.mpf, real: type) -> float:
    """Distance of a computed value from the exact one, in units of the exact value's last place."""
    if not math.isfinite(value):
        return math.inf
    if exact == 0:
        return 0.0 if value == 0 else math.inf
    spacing = mpmath.ldexp(1, mpmath.frexp(exact)[1] - np.finfo(real).nmant - 1)
    return float(abs(mpmath.mpf(value) - exact) / spacing)


def representable(exact: mpmath.mpf, real: type) -> bool:
    limits = np.finfo(real)
    return exact == 0 or float(limits.tiny) <= abs(exact) <= float(limits.max)


def is_computed(equation: Equation) -> bool:
    """Whether the statement has a kernel that depends on its arguments."""
    varies = equation.computed_by is not None or sp.sympify(equation.computed).free_symbols
    return bool(equation.over and varies)


def numeric(equation: Equation) -> CheckResult:
    """Kernels against 50 digits, and the forms of the statement against each other, over the declared domain."""
    if not is_computed(equation):
        return CheckResult("none", "nothing to compute")
    disagreement = forms_disagree(equation) or families_disagree(equation)
    if disagreement:
        return CheckResult("fail", disagreement)
    measured: dict[str, Any] = {}
    for real, promise in zip((np.float64, np.float32), equation.within, strict=True):
        error, where = worst_error(equation, real)
        measured[real.__name__] = {"ulps": error, "at": where, "promised": promise}
    broken = [
        f"{name} kernel off by {result['ulps']:.3g} ulps (promised {result['promised']:g}) at {result['at']}"
        for name, result in measured.items()
        if not result["ulps"] <= result["promised"]
    ]
    if broken:
        return CheckResult("fail", "; ".join(broken), measured)
    return CheckResult("pass", ", ".join(f"{name} {result['ulps']:.2g} ulps" for name, result in measured.items()), measured)


def worst_error(equation: Equation, real: type) -> tuple[float, str]:
    """The largest error of the kernel that a search finds, in ulps, and the arguments where it occurs.

    The search begins at arguments over the whole domain, and goes on near those of the largest errors.
    """
    points = sample(equation, real)
    errors = errors_at(equation, points, real)
    random = _random(equation)
    for _ in range(ROUNDS):
        worst = np.argsort(errors, kind="stable")[-WORST:]
        further = near(equation, np.repeat(points[worst], PER_POINT, axis=0), random)
        points = np.vstack([points[worst], further])
        errors = np.concatenate([errors[worst], errors_at(equation, further, real)])
    worst_of_all = int(np.argmax(errors))
    named = zip(equation.arguments, points[worst_of_all], strict=True)
    return float(errors[worst_of_all]), ", ".join(f"{name}={float(value):.9g}" for name, value in named)


def errors_at(equation: Equation, points: np.ndarray, real: type) -> np.ndarray:
    """Errors of the kernel in ulps at arguments (n, ...), infinite in another precision than asked for."""
    values = np.atleast_1d(equation.kernel(*points.T))
    if values.dtype != real:
        return np.full(len(points), math.inf)
    exact = [equation.exact(*point) for point in points]
    pairs = zip(values, exact, strict=True)
    return np.array([ulps(float(value), number, real) if representable(number, real) else 0.0 for value, number in pairs])


def forms_disagree(equation: Equation) -> str:
    """A sentence if definition, closed form and stable rewrite are not the same number at some argument, else nothing."""
    forms = {"means": equation.means, "equals": equation.equals, "computed_as": equation.computed_as}
    usable = {name: sp.sympify(form).subs(equation.where) for name, form in forms.items() if _evaluable(form)}
    if len(usable) < 2 or equation.relation != "=":
        return ""
    symbols = sorted(set().union(*(form.free_symbols for form in usable.values())), key=str)
    evaluators = {name: reference(form, symbols) for name, form in usable.items()}
    *others, computed = evaluators
    for point in itertools.islice(_printed_points(equation, symbols), 12):
        base = evaluators[computed](*point)
        if not representable(base, np.float64):
            continue
        for name in others:
            apart = abs(evaluators[name](*point) - base)
            if apart > abs(base) * mpmath.mpf(10) ** -AGREE:
                at = ", ".join(f"{s}={float(v):.6g}" for s, v in zip(symbols, point, strict=True))
                return f"{name} differs from {computed} by {float(apart):.3g} at {at}"
    return ""


def families_disagree(equation: Equation) -> str:
    """A sentence if a family that names the statement has a kernel of another value at some argument, else nothing.

    Kernels are called as they are written, without the compiler.
    """
    for kind, role in stating(equation):
        promise, values = (SAME_LAMBDA, _values_of_Lambda) if role == "Lambda" else (equation.within[0], _values)
        for point, value, exact in values(equation, kind):
            error = ulps(value, exact, np.float64) if representable(exact, np.float64) else 0.0
            if not error <= promise:
                at = ", ".join(f"{float(number):.9g}" for number in point)
                return f"the kernel of {role} of {kind.__name__} is off by {error:.3g} ulps at ({at})"
    return ""


def _values(equation: Equation, kind: Any) -> Iterable[tuple[np.ndarray, float, mpmath.mpf]]:
    """At a normal or a cosine, and at arguments of the constructor."""
    for point in sample(equation, np.float64):
        *wm, cosine = map(float, point[: 3 if isinstance(next(iter(equation.over)), Direction) else 1])
        arguments = map(float, point[len(wm) + 1 :])
        yield point, kind.kernel((*wm, cosine) if wm else cosine, kind(*arguments).parameters), equation.exact(*point)


def _values_of_Lambda(equation: Equation, kind: Any) -> Iterable[tuple[np.ndarray, float, mpmath.mpf]]:
    """At directions and alphas, from which the argument of the statement is computed to 50 digits."""
    argument = equations["visibility.smith.a"]
    for point in sample(argument, np.float64):
        wo, alphas = tuple(map(float, point[:3])), map(float, point[3:])
        yield point, kind.closed_Lambda(wo, kind(*alphas).parameters), equation.exact(argument.exact(*point))


def _evaluable(form: Any) -> bool:
    return form is not None and not sp.sympify(form).has(sp.Integral, sp.Derivative, sp.Limit)


# --- arguments ------------------------------------------------------------------------------------------------------


def _random(equation: Equation) -> np.random.Generator:
    return np.random.default_rng(zlib.crc32(equation.key.encode()))


def _ends(interval: Any) -> tuple[float, float]:
    low, high = interval
    return float(low), float(high)


def _interval(interval: Any, fraction: np.ndarray) -> np.ndarray:
    """Numbers in [0, 1] mapped to an interval, logarithmically when it spans more than two decades."""
    low, high = _ends(interval)
    if low > 0 and high > 100 * low:
        return np.exp(np.log(low) + fraction * (np.log(high) - np.log(low))).clip(low, high)
    return low + fraction * (high - low)


GRAZING = 1e-6 * math.pi / 180  # directions come this near to the horizon, in radians


def _angle(fraction: np.ndarray, kind: str) -> np.ndarray:
    """Polar angles: dense near 0 and near the horizon, where formulae break."""
    near = np.exp(np.log(1e-9) * (1 - fraction)) * math.pi / 4
    far = math.pi / 2 - np.exp(np.log(GRAZING) * fraction)
    theta = np.where(np.arange(len(fraction)) % 2 == 0, near, far)
    return np.where(np.arange(len(fraction)) % 3 == 0, math.pi - theta, theta) if kind == "sphere" else theta


def sample(equation: Equation, real: type) -> np.ndarray:
    """Arguments over the declared domain, its corners first, rounded to the precision."""
    random = _random(equation)
    columns: list[np.ndarray] = []
    corners = list(itertools.islice(itertools.product((0.0, 1.0), repeat=len(equation.over)), 64))
    fractions = np.vstack([corners, random.random((POINTS - len(corners), len(equation.over)))])
    for (argument, domain), fraction in zip(equation.over.items(), fractions.T, strict=True):
        if isinstance(argument, Direction):
            theta, phi = _angle(fraction, domain), random.random(len(fraction)) * 2 * math.pi
            columns += [np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)]
        else:
            columns.append(_clip(_interval(domain, fraction).astype(real), domain, real))
    return np.stack(columns, axis=1).astype(real)


def near(equation: Equation, points: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Arguments of the domain that differ from the given ones (n, ...), some by a few ulps and some by a tenth."""
    real = points.dtype.type
    steps = 10 ** random.uniform(math.log10(np.finfo(real).eps), -1, points.shape) * random.standard_normal(points.shape)
    moved = points.astype(float) * np.exp(steps * random.integers(2, size=points.shape))
    columns, at = [], 0
    for argument, domain in equation.over.items():
        if isinstance(argument, Direction):
            direction = moved[:, at : at + 3]
            columns += list((direction / np.linalg.norm(direction, axis=1, keepdims=True)).T.astype(real))
            at += 3
        else:
            low, high = _ends(domain)
            columns.append(_clip(moved[:, at].clip(low, high).astype(real), domain, real))
            at += 1
    return np.stack(columns, axis=1)


def _clip(values: np.ndarray, interval: Any, real: type) -> np.ndarray:
    """Rounding may step over an end of the interval: step back inside."""
    low, high = _ends(interval)
    inside = np.where(values > high, np.nextafter(values, real(-np.inf)), values)
    return np.asarray(np.where(inside < low, np.nextafter(inside, real(np.inf)), inside))


def _printed_points(equation: Equation, symbols: Sequence[sp.Symbol]) -> Iterable[list[mpmath.mpf]]:
    """Arguments in the symbols that are printed, well inside the domain."""
    domains: dict[sp.Symbol, Any] = {}
    for argument, domain in equation.over.items():
        if isinstance(argument, Direction):
            domains |= {argument.theta: (0.01, 1.56), argument.phi: (0, 6.28)}
            domains |= dict.fromkeys(argument.components, (0.05, 0.95))
        else:
            domains[argument] = domain
    random = _random(equation)
    while True:
        fractions = random.random((len(symbols), 1))
        yield [
            mpmath.mpf(float(_interval(domains.get(s, (0.05, 1.5)), fraction)[0]))
            for s, fraction in zip(symbols, fractions, strict=True)
        ]
