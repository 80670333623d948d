"""The albedo by another sum: rays of slopes over the scales, cut where anything has a kink or a singularity beside the ray.

Nothing is shared with the library: D, Lambda, G2 and F are written out again, in other forms, and so is the rule. Between two
cuts a ray is halved. Either half is taken in a variable whose square is the distance from the cut, or, beyond a width that the
cut has, its logarithm; the same holds for the angle beside rays whose cuts change. Intervals are halved until Gauss's rule and
the same rule on both halves agree. All is done twice, with other nodes and other intervals: their difference is the error.
"""

from __future__ import annotations

from math import asinh, atan2, erfc, exp, expm1, inf, log, log1p, pi, sin, sinh, sqrt
from typing import NamedTuple

import microfacet as mf
import numba
import numpy as np

NDFS = {mf.GGX: 0, mf.Beckmann: 1, mf.Ward: 2, mf.BlinnPhong: 3, mf.NormalizedBlinnPhong: 3}
HEIGHT, NONE, DIRECTION, HEIGHT_DIRECTION, CAVITY, IMPLICIT, KELEMEN, SCHLICK_SMITH = range(8)
SMITHS = {"height": HEIGHT, "none": NONE, "direction": DIRECTION, "height-direction": HEIGHT_DIRECTION}
OTHERS = {mf.VCavity: CAVITY, mf.Implicit: IMPLICIT, mf.Kelemen: KELEMEN, mf.SchlickSmith: SCHLICK_SMITH}
MIRROR, INDEX, SCHLICK = range(3)
TINY = 1e-300
FAR = 8.0  # scales, beyond which a normal distribution of slopes counts nothing


class Case(NamedTuple):
    """A BRDF and a view, in numbers."""

    ndf: int
    masking: int
    fresnel: int
    ax: float
    ay: float
    weight: float  # what D has for a factor, over that of a density of slopes
    power: float  # of cosines
    far: float
    k: float  # of Schlick's masking, or the largest roughness
    n: complex  # index
    F: tuple[float, float, float]  # at normal and grazing incidence, and what is taken off
    z: float
    tx: float  # the view's tangents
    ty: float
    Lo: float  # Lambda of the view
    table: np.ndarray  # of Lambda, where it is an integral


class Ray(NamedTuple):
    dx: float
    dy: float
    lean: float  # what the view's facing falls by
    square: float
    cross: float  # by which the ray leaves the view's plane
    rim: float  # where light comes from the horizon
    Lo: float


jit = numba.njit(error_model="numpy", cache=True)

# --- the integrand --------------------------------------------------------------------------------------------------


@jit
def dielectric(c: float, n: float) -> float:
    beyond = (n - 1.0) * (n + 1.0) + c * c
    if not beyond > 0.0:
        return 1.0 if n < 1.0 else 0.0
    g = sqrt(beyond)
    across = (n - 1.0) * (n + 1.0) / ((c + g) * (c + g))
    along = (n - 1.0) * (n + 1.0) * ((n * n + 1.0) * c * c - 1.0) / ((n * n * c + g) * (n * n * c + g))
    return 0.5 * (across * across + along * along)


@jit
def reflectance(c: float, case: Case) -> float:
    if case.fresnel == MIRROR:
        return 1.0
    if case.fresnel == SCHLICK:
        u = 1.0 - c
        return case.F[0] + (case.F[1] - case.F[0]) * u**5 - case.F[2] * c * u**6
    if case.n.imag == 0.0:
        return dielectric(c, case.n.real)
    n = case.n
    beyond = (n - 1.0) * (n + 1.0) + c * c
    g = np.sqrt(beyond)
    across = (n - 1.0) * (n + 1.0) / ((c + g) * (c + g))
    along = (n - 1.0) * (n + 1.0) * ((n * n + 1.0) * c * c - 1.0) / ((n * n * c + g) * (n * n * c + g))
    return 0.5 * (across.real**2 + across.imag**2 + along.real**2 + along.imag**2)


@jit
def facets(r: float, S: float, case: Case) -> float:
    """The density of slopes, times both scales; S: 1 over the square of the facet's height."""
    if case.ndf == 0:
        return case.weight / (1.0 + r * r) ** 2
    if case.ndf == 3:
        return (
            case.weight * exp(-case.power * log1p(S - 1.0))
            if S > 2.0
            else case.weight * exp(-case.power * log1p((r * case.ax) ** 2))
        )
    return case.weight * exp(-r * r) / S**case.power


@jit
def series(tangent: float, table: np.ndarray) -> float:
    """Lambda from its table: what is hidden, over the scale, by Chebyshev's series of pieces of the tangent's logarithm."""
    if not tangent > SMALLEST:
        return 0.0
    place = min(log(tangent / SMALLEST) / PIECE, len(table) - 1e-9)
    row = int(place)
    t = 2.0 * (place - row) - 1.0
    a, b = 0.0, 0.0
    for k in range(table.shape[1] - 1, 0, -1):
        a, b = 2.0 * t * a - b + table[row, k], a
    return (t * a - b + table[row, 0]) * tangent


@jit
def Lambda(square: float, case: Case) -> float:
    """square: of the tangent, stretched by the scales."""
    if case.ndf == 0:
        return 0.5 * square / (1.0 + sqrt(1.0 + square))
    if not square > 0.0:
        return 0.0
    if case.ndf == 1:
        return 0.5 * (sqrt(square / pi) * exp(-1.0 / square) - erfc(1.0 / sqrt(square)))
    return series(sqrt(square), case.table)


@jit
def seen_and_lit(shown: float, S: float, Px: float, Py: float, Pz: float, turned: float, case: Case) -> float:
    """G2 for light along (-Px, -Py, Pz). turned: what the sine of its azimuth from the view is proportional to."""
    if case.masking == CAVITY:
        return min(1.0, 2.0 / shown, 2.0 * Pz / (S * shown))
    iz = case.z * Pz / S
    if case.masking == IMPLICIT:
        return case.z * iz
    if case.masking == KELEMEN:
        return Pz / (shown * shown)
    if case.masking == SCHLICK_SMITH:
        k = case.k
        return case.z / (case.z + k * (1.0 - case.z)) * iz / (iz + k * (1.0 - iz))
    Li, Lo = Lambda(((case.ax * Px) ** 2 + (case.ay * Py) ** 2) / (Pz * Pz), case), case.Lo
    if case.masking == HEIGHT:
        return 1.0 / (1.0 + Lo + Li)
    if case.masking == NONE:
        return 1.0 / (1.0 + Lo) / (1.0 + Li)
    apart = 4.41 * abs(atan2(turned, -(case.tx * Px + case.ty * Py)))
    blend = apart / (1.0 + apart)
    if case.masking == HEIGHT_DIRECTION:
        return 1.0 / (1.0 + max(Lo, Li) + blend * min(Lo, Li))
    return blend / (1.0 + Lo) / (1.0 + Li) + (1.0 - blend) / (1.0 + max(Lo, Li))


@jit
def light(r: float, ray: Ray, case: Case) -> float:
    """What facets of one slope send, per angle and radius."""
    shown = 1.0 - r * ray.lean
    S = 1.0 + r * r * ray.square
    Pz = (1.0 - r / ray.rim) * (1.0 + r * ray.rim * ray.square)
    if not (shown > 0.0 and Pz > 0.0):
        return 0.0
    Px, Py = 2.0 * shown * r * ray.dx + case.tx * S, 2.0 * shown * r * ray.dy + case.ty * S
    G2 = seen_and_lit(shown, S, Px, Py, Pz, 2.0 * shown * r * ray.cross, case)
    return reflectance(min(case.z * shown / sqrt(S), 1.0), case) * G2 * shown * facets(r, S, case) * r


# --- where a ray is cut ---------------------------------------------------------------------------------------------


@jit
def quadratic(a: complex, b: complex, c: complex) -> tuple[complex, complex]:
    """The roots of a + b r + c r^2; at infinity where there are none."""
    root = np.sqrt(b * b - 4.0 * a * c)
    if (b * root.conjugate()).real < 0.0:
        root = -root
    both = -0.5 * (b + root)
    none = complex(inf, 0.0)
    return (a / both if abs(both) > 0.0 else none), (both / c if abs(c) > 0.0 else none)


@jit
def value(p: np.ndarray, degree: int, x: float) -> float:
    total = 0.0
    for k in range(degree, -1, -1):
        total = total * x + p[k]
    return total


@jit
def real_roots(p: np.ndarray, high: float) -> np.ndarray:
    """Of a cubic in (0, high): between those of its derivatives there is at most one."""
    turns = np.empty(0)
    for degree in range(1, 4):
        q = p.copy()
        for _ in range(3 - degree):
            q = np.append(q[1:] * np.arange(1.0, len(q)), 0.0)
        ends = np.concatenate((np.array([0.0]), turns, np.array([high])))
        found = np.empty(3)
        count = 0
        for k in range(len(ends) - 1):
            a, b = ends[k], ends[k + 1]
            below = value(q, degree, a) < 0.0
            if below == (value(q, degree, b) < 0.0):
                continue
            for _ in range(200):
                middle = 0.5 * (a + b) if b < 4.0 * a or a == 0.0 else sqrt(a * b)
                if middle <= a or middle >= b:
                    break
                if (value(q, degree, middle) < 0.0) == below:
                    a = middle
                else:
                    b = middle
            found[count] = b
            count += 1
        turns = found[:count].copy()
    return turns


class Cuts(NamedTuple):
    """Places along a ray at or beside which something is not smooth, within which widths, and how many there are so far."""

    places: np.ndarray
    widths: np.ndarray
    count: np.ndarray


@jit
def note(place: float, width: float, found: Cuts, last: float) -> None:
    """A cut, if it is on the ray; what is wider than its place is cut elsewhere."""
    if 0.0 < place < last:
        found.places[found.count[0]], found.widths[found.count[0]] = place, min(width, place)
        found.count[0] += 1


@jit
def note_light(ray: Ray, case: Case, last: float, found: Cuts) -> None:
    """Where light comes from along an axis, or nearly so, and is masked least: how wide that is, the other axis tells."""
    ax, ay = (case.k, case.k) if case.masking == SCHLICK_SMITH else (case.ax, case.ay)
    for d, t, e, u, mine, other in (
        (ray.dx, case.tx, ray.dy, case.ty, ax, ay),
        (ray.dy, case.ty, ray.dx, case.tx, ay, ax),
    ):
        bend = t * ray.square - 2.0 * ray.lean * d
        for root in quadratic(complex(t), complex(2.0 * d), complex(bend)):
            r = root.real
            S, shown = 1.0 + r * r * ray.square, 1.0 - r * ray.lean
            width = np.hypot(other * (2.0 * shown * r * e + u * S), 2.0 * shown - S) / (
                mine * abs(2.0 * d + 2.0 * r * bend) + TINY
            )
            note(r, abs(root.imag) + width, found, last)


@jit
def edge(ray: Ray, case: Case) -> float:
    """The share of a ray that is left where masking of light begins to rise steeply, at the horizon."""
    ax, ay = (case.k, case.k) if case.masking == SCHLICK_SMITH else (case.ax, case.ay)
    twice, S = 2.0 * (1.0 - ray.rim * ray.lean) * ray.rim, 1.0 + ray.rim * ray.rim * ray.square
    return min(1.0, np.hypot(ax * (twice * ray.dx / S + case.tx), ay * (twice * ray.dy / S + case.ty)))


@jit
def note_index(ray: Ray, case: Case, last: float, found: Cuts) -> None:
    """Where the refracted cosine is 0 or, for complex places and indices, nearest to it."""
    level, zz = (1.0 - case.n) * (1.0 + case.n), case.z * case.z
    one, two = quadratic(zz - level, complex(-2.0 * zz * ray.lean), zz * ray.lean * ray.lean - level * ray.square)
    apart = abs(one.real - two.real)
    note(one.real, abs(one.imag) if one.imag != 0.0 else apart, found, last)
    note(two.real, abs(two.imag) if two.imag != 0.0 else apart, found, last)


@jit
def note_creases(ray: Ray, case: Case, last: float, found: Cuts) -> None:
    """Where two of the terms of a smallest, or of a largest, are equal."""
    lean, square = ray.lean, ray.square
    if case.masking == CAVITY:
        note(-1.0 / lean if lean != 0.0 else inf, inf, found, last)
        note(-lean / square, inf, found, last)
        cubic = np.array([-1.0, 3.0 * lean, 3.0 * square, -lean * square])
    else:
        cubic = equal(ray, case)
    for r in real_roots(cubic, last):
        note(r, inf, found, last)


@jit
def cuts(ray: Ray, case: Case, last: float) -> tuple[np.ndarray, np.ndarray]:
    """All places from the begin of a ray to its end, in order, and their widths."""
    found = Cuts(np.empty(24), np.empty(24), np.zeros(1, np.int64))
    note(1.0, 1.0, found, last)
    rises = case.masking <= HEIGHT_DIRECTION or case.masking == SCHLICK_SMITH
    if rises:
        note_light(ray, case, last, found)
    if case.fresnel == INDEX:
        note_index(ray, case, last, found)
    if case.masking == CAVITY or case.masking == DIRECTION or case.masking == HEIGHT_DIRECTION:
        note_creases(ray, case, last, found)
    count = found.count[0]
    order = np.argsort(found.places[:count])
    first = min(1.0, 1.0 / sqrt(ray.square), 1.0 / (abs(ray.lean) + TINY))
    end = last * edge(ray, case) if rises and last == ray.rim else last
    places = np.concatenate((np.array([0.0]), found.places[order], np.array([last])))
    return places, np.concatenate((np.array([first]), found.widths[order], np.array([end])))


@jit
def equal(ray: Ray, case: Case) -> np.ndarray:
    """What vanishes where light and viewer are masked equally, over the radius."""
    P = np.zeros((3, 3))
    for k, d, t, a in ((0, ray.dx, case.tx, case.ax), (1, ray.dy, case.ty, case.ay)):
        P[k] = a * t, 2.0 * a * d, a * (t * ray.square - 2.0 * ray.lean * d)
    P[2] = np.array([1.0, -2.0 * ray.lean, -ray.square]) * np.hypot(case.ax * case.tx, case.ay * case.ty)
    total = np.zeros(5)
    for k, sign in ((0, 1.0), (1, 1.0), (2, -1.0)):
        for i in range(3):
            for j in range(3):
                total[i + j] += sign * P[k, i] * P[k, j]
    return total[1:]


# --- the rule -------------------------------------------------------------------------------------------------------

DEEPEST = 60


class Rule(NamedTuple):
    nodes: np.ndarray  # Gauss's, in (0, 1)
    weights: np.ndarray
    share: float  # of the way between two cuts, where their halves meet
    goal: float  # error of the integral over an interval of angles, of the whole
    ray_goal: float  # of an interval along a ray, of the ray


@jit
def gauss(low: float, high: float, start: float, width: float, most: float, ray: Ray, case: Case, rule: Rule) -> float:
    """Over r = start + width sinh(most v^2), v between low and high."""
    total = 0.0
    for k in range(len(rule.nodes)):
        v = low + (high - low) * rule.nodes[k]
        rise = expm1(most * v * v)
        fall = 1.0 / (1.0 + rise)
        total += rule.weights[k] * light(start + 0.5 * width * rise * (1.0 + fall), ray, case) * v * (1.0 + rise + fall)
    return total * abs(width) * most * (high - low)


@jit
def along(ray: Ray, case: Case, rule: Rule) -> tuple[float, float]:
    """The integral along a ray, and its error."""
    last = min(ray.rim, case.far)
    places, widths = cuts(ray, case, last)
    pieces = 2 * (len(places) - 1)
    starts, sizes, mosts, parents = np.zeros(pieces), np.ones(pieces), np.zeros(pieces), np.zeros(pieces)
    for k in range(pieces):
        at = (k + 1) // 2
        gap = places[k // 2 + 1] - places[k // 2]
        if not gap > 0.0:
            continue
        far = gap * (rule.share if k % 2 == 0 else 1.0 - rule.share)
        size = min(max(widths[at], 1e-30 * far), far)
        starts[k], sizes[k], mosts[k] = places[at], size if k % 2 == 0 else -size, asinh(far / size)
        parents[k] = gauss(0.0, 1.0, starts[k], sizes[k], mosts[k], ray, case, rule)
    whole_ray, total, off = parents.sum(), 0.0, 0.0
    lows, highs, values = np.empty(2 * DEEPEST), np.empty(2 * DEEPEST), np.empty(2 * DEEPEST)
    for k in range(pieces):
        if mosts[k] == 0.0:
            continue
        lows[0], highs[0], values[0] = 0.0, 1.0, parents[k]
        left = 1
        while left > 0:
            left -= 1
            low, high, whole = lows[left], highs[left], values[left]
            middle = 0.5 * (low + high)
            first = gauss(low, middle, starts[k], sizes[k], mosts[k], ray, case, rule)
            second = gauss(middle, high, starts[k], sizes[k], mosts[k], ray, case, rule)
            apart = abs(first + second - whole)
            if apart <= rule.ray_goal * max(whole_ray, total, first + second) or high - low < 1e-9 or left > 2 * DEEPEST - 3:
                total += first + second
                off += apart
            else:
                lows[left], highs[left], values[left] = low, middle, first
                lows[left + 1], highs[left + 1], values[left + 1] = middle, high, second
                left += 2
    return total, off


@jit
def turned(base: np.ndarray, angle: float, case: Case) -> Ray:
    """The ray at an angle from one whose direction, lean and cross are given, with their derivatives."""
    c, s = np.cos(angle), sin(angle)
    u, v = c * base[0] - s * base[1], s * base[0] + c * base[1]
    dx, dy = case.ax * u, case.ay * v
    lean, cross = c * base[2] + s * base[3], c * base[4] + s * base[5]
    square = dx * dx + dy * dy
    root = sqrt(lean * lean + square)
    rim = 1.0 / (lean + root) if lean >= 0.0 else (root - lean) / square
    return Ray(dx, dy, lean, square, cross, rim, case.Lo)


@jit
def fan(low: float, high: float, base: np.ndarray, width: float, most: float, case: Case, rule: Rule) -> tuple[float, float]:
    """Over angles width sinh(most v^2) from a ray, v between low and high: the integral, and the error of the rays."""
    total, off = 0.0, 0.0
    for k in range(len(rule.nodes)):
        v = low + (high - low) * rule.nodes[k]
        t = most * v * v
        found, error = along(turned(base, width * sinh(t), case), case, rule)
        weight = rule.weights[k] * 2.0 * v * np.cosh(t) * abs(width) * most * (high - low)
        total += weight * found
        off += weight * error
    return total, off


@jit
def around(
    bases: np.ndarray, widths: np.ndarray, mosts: np.ndarray, case: Case, rule: Rule, size: float
) -> tuple[float, float]:
    """The integral over all rays, and its error. size: about that of the integral, to tell when it is close."""
    total, off = 0.0, 0.0
    lows, highs, values = np.empty(2 * DEEPEST), np.empty(2 * DEEPEST), np.empty(2 * DEEPEST)
    for k in range(len(mosts)):
        lows[0], highs[0] = 0.0, 1.0
        values[0], _ = fan(0.0, 1.0, bases[k], widths[k], mosts[k], case, rule)
        left = 1
        while left > 0:
            left -= 1
            low, high, whole = lows[left], highs[left], values[left]
            middle = 0.5 * (low + high)
            first, off_1 = fan(low, middle, bases[k], widths[k], mosts[k], case, rule)
            second, off_2 = fan(middle, high, bases[k], widths[k], mosts[k], case, rule)
            apart = abs(first + second - whole)
            if apart <= rule.goal * size or high - low < 1e-9 or left > 2 * DEEPEST - 3:
                total += first + second
                off += apart + off_1 + off_2
            else:
                lows[left], highs[left], values[left] = low, middle, first
                lows[left + 1], highs[left + 1], values[left + 1] = middle, high, second
                left += 2
    return total, off


# --- rays beside which cuts change ----------------------------------------------------------------------------------

NARROW = 1e-6  # an angle that is narrow enough beside a ray where roots meet


def changes(case: Case) -> np.ndarray:
    """Cosines of the azimuth from the view, in slopes, at which total reflection or creases of cavities change along a ray."""
    sine, found = case.z * np.hypot(case.tx, case.ty), []
    level = ((1 - case.n) * (1 + case.n)).real if case.fresnel == INDEX else 0.0
    if 0 < level < 1:
        grazing = (2 * level - 1) / sine  # cosine between the azimuths of view and light, where it is at the horizon
        found += [-(sine + grazing) / sqrt(1 + sine**2 + 2 * sine * grazing)] if abs(grazing) < 1 else []
        found += [touch / sine for touch in (sqrt(level - case.z**2), -sqrt(level - case.z**2))] if level > case.z**2 else []
    if case.masking == CAVITY:  # three creases meet; one meets the edge
        found += [-case.z / sine, -case.z / sine / sqrt(3)]
    return np.array([cosine for cosine in found if abs(cosine) < 1])


def of_the_axes(case: Case) -> list[tuple[float, float]]:
    """Slopes along rays that touch where light comes along an axis, or meet it at the edge."""
    found = []
    for turn in (False, True):
        tx, ty = (case.ty, case.tx) if turn else (case.tx, case.ty)
        if tx == 0:
            continue
        slopes = [(tx, ty + s / case.z) for s in (1, -1)] + [(-tx * case.z, -ty * case.z - s) for s in (1, -1)]
        for a, b in slopes:
            found += [(b, a), (-b, -a)] if turn else [(a, b), (-a, -b)]
    return found


def special(case: Case) -> list[tuple[float, float, float, int]]:
    """Rays, not of unit length, and the angle within which things change beside them; 1 where lean is 0, 2 where cross is."""
    ax, ay, tx, ty = case.ax, case.ay, case.tx, case.ty
    found = [(s * u, s * v, w, 0) for s in (1, -1) for u, v, w in ((1.0, 0.0, min(1, ax / ay)), (0.0, 1.0, min(1, ay / ax)))]
    T = float(np.hypot(tx, ty))
    if T == 0:
        return found
    x, y = tx / T, ty / T

    def stretch(px: float, py: float) -> float:
        """By how much angles are wider over the scales, next to a slope."""
        return 1 / (ax * ay) / ((px / ax) ** 2 + (py / ay) ** 2) / np.hypot(px, py) ** -2

    tip = (1 + 1 / case.z) / T / max(ax, ay, 1.0)
    for s in (1, -1):
        u, v = -s * ay * y / np.hypot(ay * y, ax * x), s * ax * x / np.hypot(ay * y, ax * x)
        found.append((u, v, np.hypot(ax * u, ay * v) / np.hypot(ax * tx, ay * ty), 1))
        found.append((s * x / ax, s * y / ay, tip * stretch(x, y), 2))
    sides = [(c * x - s * y, s * x + c * y) for c in changes(case) for s in (sqrt((1 - c) * (1 + c)), -sqrt((1 - c) * (1 + c)))]
    if ax != ay and case.masking <= HEIGHT_DIRECTION:
        sides += of_the_axes(case)
    return found + [(px / ax, py / ay, NARROW * stretch(px, py), 0) for px, py in sides]


def panels(case: Case, share: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """From each special ray part of the way to the next, and back: the ray, the width with its sign, and how far."""
    rays = sorted(special(case), key=lambda ray: atan2(ray[1], ray[0]))
    bases = []
    for u, v, _, kind in rays:
        u, v = u / np.hypot(u, v), v / np.hypot(u, v)
        dx, dy = case.ax * u, case.ay * v
        lean, cross = (dx * case.tx + dy * case.ty) * (kind != 1), (case.tx * dy - case.ty * dx) * (kind != 2)
        bases.append(
            [u, v, lean, case.ay * u * case.ty - case.ax * v * case.tx, cross, case.tx * case.ay * u + case.ty * case.ax * v]
        )
    count, widths = len(bases), [ray[2] for ray in rays]
    pairs = [(bases[k], bases[(k + 1) % count]) for k in range(count)]
    gaps = [atan2(a[0] * b[1] - a[1] * b[0], a[0] * b[0] + a[1] * b[1]) for a, b in pairs]
    for k in [*range(2 * count), *range(2 * count, 0, -1)]:  # what is narrow beside a ray is so for the next one
        here, there = k % count, (k + 1) % count
        widths[there] = min(widths[there], widths[here] + gaps[here])
        widths[here] = min(widths[here], widths[there] + gaps[here])
    found = []
    for k, (first, second) in enumerate(pairs):
        for base, width, far in ((first, widths[k], gaps[k] * share), (second, widths[(k + 1) % count], gaps[k] * (share - 1))):
            if gaps[k] > 0:
                size = min(max(width, 1e-30), abs(far))
                found.append((base, np.copysign(size, far), asinh(abs(far) / size)))
    return np.array([f[0] for f in found]), np.array([f[1] for f in found]), np.array([f[2] for f in found])


# --- the whole ------------------------------------------------------------------------------------------------------

SMALLEST, PIECE, TERMS, PIECES = 1e-7, 0.5, 12, 88


def table_of(case: Case) -> np.ndarray:
    """What equal slopes on all sides hide over the scale, over the logarithm of the stretched tangent.

    A ring of slopes sqrt(c^2 + t^2), c the view's cotangent, hides 2 (t - c atan(t/c)) in all.
    """
    places = np.cos(np.pi * (np.arange(TERMS) + 0.5) / TERMS)
    tangent = SMALLEST * np.exp(PIECE * (np.arange(PIECES)[:, None] + (places + 1) / 2))
    c = (case.ax / tangent)[..., None]
    t = case.ax * np.exp(np.arange(-30, 40, 0.1))
    S = c * c + t * t
    density = np.exp(-S / case.ax**2) / (1 + S) ** case.power if case.ndf == 2 else np.exp(-case.power * np.log1p(S))
    hidden = 0.2 * (case.weight * density * (t - c * np.arctan(t / c)) * t * t).sum(axis=-1) / case.ax**3
    make = np.cos(np.outer(np.arange(TERMS), np.pi * (np.arange(TERMS) + 0.5) / TERMS)) * 2 / TERMS
    make[0] /= 2
    return np.asarray(hidden @ make.T)


def case_of(brdf: mf.Microfacet, wo: np.ndarray) -> Case:
    model, fresnel = brdf.model, brdf.fresnel
    ndf, p = model.ndf, fresnel.parameters
    kind = NDFS[type(ndf)]
    ax, ay = ndf.slope_scale
    weight, power, far = 1 / pi, {2: 2.0}.get(kind, 0.0), FAR if kind in (1, 2) else inf
    if kind == 3:
        ax = ay = 1 / sqrt(1 + ndf.n / 2)
        power = ndf.n / 2 + 2
        weight = 1 / pi if type(ndf) is mf.NormalizedBlinnPhong else ax * ay
    masking = SMITHS[model.correlation] if type(model) is mf.Smith else OTHERS[type(model)]
    n, F, law = 1 + 0j, (1.0, 1.0, 0.0), MIRROR
    if type(fresnel) in (mf.Dielectric, mf.Conductor):
        law, n = INDEX, complex(*p)
    elif type(fresnel) is mf.Schlick:
        law, F = SCHLICK, (p[0], p[1], 0.0)
    elif type(fresnel) is mf.F82Tint:
        law, edge = SCHLICK, p[0] + (p[2] - p[0]) * (6 / 7) ** 5
        F = (p[0], p[2], (1 - p[1]) * edge * 7 * (7 / 6) ** 6)
    z = float(wo[2])
    k = model.k if masking == SCHLICK_SMITH else 0.0
    case = Case(kind, masking, law, ax, ay, weight, power, far, k, n, F, z, wo[0] / z, wo[1] / z, 0.0, np.zeros((1, 1)))
    if masking <= HEIGHT_DIRECTION:
        case = case._replace(table=table_of(case)) if kind in (2, 3) else case
        case = case._replace(Lo=Lambda((ax * case.tx) ** 2 + (ay * case.ty) ** 2, case))
    return case


RULES = ((8, 0.5), (11, 0.39))  # nodes, and where halves between cuts meet
GOALS = ((2e-11, 1e-12), (2e-13, 2e-14))


def albedo(brdf: mf.Microfacet, wo: np.ndarray, size: float, wanted: float) -> tuple[float, float]:
    """By the finer of two rules, and its error. size: about how large it is. wanted: an error that is small enough."""
    case = case_of(brdf, wo)
    for goals in GOALS:
        sums = []
        for count, share in RULES:
            nodes, weights = np.polynomial.legendre.leggauss(count)
            rule = Rule((nodes + 1) / 2, weights / 2, share, *goals)
            sums.append(around(*panels(case, share), case, rule, size)[0])
        off = 3 * abs(sums[1] - sums[0]) + 1e-14 * sums[1]
        if off <= wanted:
            break
    return sums[1], off
