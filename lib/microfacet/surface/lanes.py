"""Rays against a periodic height field in lanes: many rays are stepped at once, which compiles to vector instructions.

How a hit is decided. A ray, seen from above, crosses a sequence of edges. It starts above the surface, so it hits the facet
before the first edge that it crosses below, and it leaves a facet without a hit if it crosses the next edge above. One sign
per edge decides for both facets that share it, so that no ray leaks between them. A ray that starts on a facet crosses that
facet's own edge above, whatever rounding says: there is no offset and no tolerance anywhere.

How empty space is skipped. Square blocks of 4, 16, 64, ... cells a side each have a plane that no point of the block exceeds.
Where a ray is above that plane no edge needs to be looked at. A smooth surface is nearly flat in a small block, so a ray
sinks to within a cell or two of its hit before it looks at heights. The planes only save work: they are rounded up by more
than what rounding does to a ray, and all signs that decide are taken in double precision from the heights themselves.

Many rays are stepped in lanes, without a branch, which compiles to vector instructions: through blocks, until enough of them
have nothing left to skip, and these then through a cell each. A ray's result depends on that ray only, not on the others,
on their order or on the number of threads.

Sources: smits1999 (watertight walks), tevs2008 (maximum pyramids), amanatides1987 (walking a grid).
"""

from __future__ import annotations

import math
import threading
from functools import partial
from typing import Any, cast

import numpy as np
from numba.core import cgutils, types
from numba.extending import intrinsic
from numpy.typing import NDArray

from microfacet.compiler.cache import compiled

Array = NDArray[np.float64]
Singles = NDArray[np.float32]
Integers = NDArray[np.int64]

ESCAPED = -1  # what is met in place of a facet: nothing
LOST = -2  # undecided: the ray ran almost horizontally for `REACH` cells
REACH = 2.0**24

BASE, STEP = 2, 2  # blocks have 2^BASE, 2^(BASE + STEP), ... cells a side
START = BASE + STEP  # where rays from above begin to look
CELLS, HIT, GONE = BASE - STEP, -8, -9  # what a lane may do instead of passing blocks
ASTRAY = -3
LANES = 64
MANY = 20  # lanes that wait for a step through cells before it is made
SPARE = 12  # lanes that are ready for another ray before they get it
CHUNK = 32768  # rays that a thread takes at once
RISING, FALLING = 1.5, 3.0  # half sides that a ray has to be above its block's plane before it takes wider blocks
TINY = 1e-50
LARGEST = 1e290  # stands for 1/0
MARGIN = 1e-6  # of the heights of a ray and of the highest point: how far above that point a ray may not skip
EARLY = 1 - 1e-6  # what part of the way to a plane is passed for sure, as the quotient is rounded to single precision

_njit: Any = partial(compiled, nogil=True, error_model="numpy")
_inner = _njit(_nrt=False, forceinline=True)  # no counting of references: it would cost more than the walk itself
_exact = _njit(_nrt=False)
_lanes = _njit(_nrt=False, fastmath={"contract"}, forceinline=True)

_thread = threading.local()

# Rows of the lanes' state, of LANES entries each. Rays are mirrored so that they run towards +x and +y: a mirrored axis has
# the mask -1, and the cell c of it is the cell ~c of the surface. t is the distance so far, (CX, CY) the cell there, SIZE
# the binary logarithm of the block's side, or CELLS, HIT or GONE. SIDE is the side of its cell that a ray starts on, or
# FREE more than that on which it came into its cell, or -1 if only t tells; after a HIT, the facet.

T, FX, FY, OZ, DX, DY, DZ, IX, IY, IA, END = (row * LANES for row in range(11))
CX, CY, SIZE, MX, MY, RAY, SIDE = (row * LANES for row in range(7))
FREE = 2


def _scope(module: Any) -> Any:
    """Tells LLVM that tables and lanes are different memory: only then does it turn a loop over lanes into vectors."""
    domain = module.add_metadata(["microfacet.lanes"])
    return module.add_metadata([module.add_metadata(["table", domain])])


def _load(kind: str) -> Any:
    def typed(context: Any, array: Any, index: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            data = context.make_array(signature.args[0])(context, builder, args[0]).data
            value = builder.load(builder.gep(data, [args[1]], inbounds=True))
            value.set_metadata(kind, _scope(builder.module))
            return value

        return array.dtype(array, index), generate

    return typed


_look = cast(Any, intrinsic)(_load("alias.scope"))  # _look(table, index): an entry of a table
_get = cast(Any, intrinsic)(_load("noalias"))  # _get(state, index): an entry of a lane


@cast(Any, intrinsic)
def _put(context: Any, array: Any, index: Any, value: Any) -> Any:
    """_put(state, index, value): change an entry of a lane."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        data = context.make_array(signature.args[0])(context, builder, args[0]).data
        cast = context.cast(builder, args[2], signature.args[2], signature.args[0].dtype)
        builder.store(cast, builder.gep(data, [args[1]], inbounds=True)).set_metadata("noalias", _scope(builder.module))
        return context.get_dummy_value()

    return types.void(array, index, value), generate


@cast(Any, intrinsic)
def _bits(context: Any, word: Any) -> Any:
    """How many bits are set."""
    return word(word), lambda context, builder, signature, args: builder.ctpop(args[0])


@cast(Any, intrinsic)
def _lowest(context: Any, word: Any) -> Any:
    """Which bit is the lowest that is set, of a word that is not 0."""
    return word(word), lambda context, builder, signature, args: builder.cttz(args[0], cgutils.true_bit)


@cast(Any, intrinsic)
def _wide(context: Any) -> Any:
    """Lets the function that calls it use vectors of 512 bits where there are such; LLVM prefers shorter ones."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        set.add(builder.function.attributes, '"prefer-vector-width"="512"')
        return context.get_dummy_value()

    return types.void(), generate


@_lanes
def _pass_blocks(
    s: Array, q: Integers, words: Integers, unit: float, slope: float, bits: int, top: int
) -> None:  # pragma: no cover
    """One step of every lane: over its block to the next one, or, where its plane is met, to there and into the block."""
    _wide()
    for k in range(LANES):
        cx, cy, old = _get(q, CX + k), _get(q, CY + k), _get(q, SIZE + k)
        mx, my = _get(q, MX + k), _get(q, MY + k)
        t, x, y, z = _get(s, T + k), _get(s, FX + k), _get(s, FY + k), _get(s, OZ + k)
        dx, dy, dz = _get(s, DX + k), _get(s, DY + k), _get(s, DZ + k)
        live = old >= BASE
        size = old if live else BASE
        last = (1 << size) - 1
        side = float(last + 1)
        to_x, to_y = float((cx | last) + 1) - x, float((cy | last) + 1) - y
        tx, ty = to_x * _get(s, IX + k), to_y * _get(s, IY + k)
        along_x = tx < ty
        leave = tx if along_x else ty
        blocks = 1 << (bits - size)
        row = ((blocks | (((cx >> size) ^ mx) & (blocks - 1))) << (bits - size)) | (((cy >> size) ^ my) & (blocks - 1))
        word = _look(words, row if live else 0)
        b, c = slope * (((word << 32) ^ mx) - mx), slope * (((word << 48) ^ my) - my)
        half = 0.5 * side
        gap = z - unit * word - b * (half - to_x) - c * (half - to_y)
        rate = dz - b * dx - c * dy
        here, there = gap + rate * t, gap + rate * leave
        above = here > 0.0
        clear = above & (there > 0.0)
        part = np.float64(np.float32(here) / np.float32(here - there))
        met = t + (leave - t) * (EARLY * part if part > 0.0 else 0.0)
        now = leave if clear else met
        u, v = int(side - to_x + now * dx), int(side - to_y + now * dy)
        u, v = u if u < last else last, v if v < last else last
        nx, ny = (cx & ~last) + u, (cy & ~last) + v
        nx, ny = nx if nx > cx else cx, ny if ny > cy else cy
        nx = (cx | last) + 1 if clear & along_x else nx
        ny = (cy | last) + 1 if clear & (not along_x) else ny
        now, nx, ny = now if above else t, nx if above else cx, ny if above else cy
        far = there > half * (RISING if rate > 0.0 else FALLING)
        wider = size + STEP if far & (size < top) else size
        new = wider if clear else size - STEP
        new = GONE if now > _get(s, END + k) else new
        _put(s, T + k, now if live else t)
        _put(q, CX + k, nx if live else cx)
        _put(q, CY + k, ny if live else cy)
        _put(q, SIZE + k, new if live else old)
        _put(q, SIDE + k, -1 if live & above else _get(q, SIDE + k))


@_exact
def _pass_cells(s: Array, q: Integers, z: Singles, bits: int) -> None:  # pragma: no cover
    """One step of every lane that is close to the surface: to a hit in its cell, or to the next cell and back to blocks.

    Inside a cell, u and v run from 0 to 1 in the mirrored frame. Its diagonal is u = v, or u + v = 1 if one axis is
    mirrored (`flip`); the facet of larger u or u + v is side 1. A ray leaves through u = 1 or v = 1.
    """
    _wide()
    mask = (1 << bits) - 1
    for k in range(LANES):
        old, known = _get(q, SIZE + k), _get(q, SIDE + k)
        cx, cy, mx, my = _get(q, CX + k), _get(q, CY + k), _get(q, MX + k), _get(q, MY + k)
        t, x, y, oz = _get(s, T + k), _get(s, FX + k), _get(s, FY + k), _get(s, OZ + k)
        dx, dy, dz = _get(s, DX + k), _get(s, DY + k), _get(s, DZ + k)
        live, flip = old == CELLS, mx != my
        z00, z10, z01, z11 = _corners(z, cx, cy, mx, my, bits, live)
        u, v = x - cx, y - cy
        aside = u + v - 1.0 if flip else u - v
        free = (known < 0) | (known >= FREE)
        side = (known & 1) != 0 if known >= 0 else aside + t * (dx + dy if flip else dx - dy) > 0.0
        tx, ty = (1.0 - u) * _get(s, IX + k), (1.0 - v) * _get(s, IY + k)
        along_x = tx < ty
        leave = tx if along_x else ty
        parallel_map = v + tx * dy if along_x else u + ty * dx
        start = z10 if along_x else z01
        under_edge = oz + leave * dz < start + parallel_map * (z11 - start)
        middle = (1.0 - u - v if flip else v - u) * _get(s, IA + k)
        middle = middle if middle > t else t
        middle = middle if middle < leave else leave
        start, stop = z01 if flip else z00, z10 if flip else z11
        under_middle = oz + middle * dz < start + (u + middle * dx) * (stop - start)
        out = flip | along_x
        before = (out != side) & under_middle & free
        hit = before | (under_edge & ((out != side) | free))
        on = out != before  # the side that is hit, if one is
        b, c = _slopes(on, flip, z00, z10, z01, z11)
        base = z11 - b - c if flip & on else z00
        met = (base + b * u + c * v - oz) / (dz - b * dx - c * dy)
        met = met if met > t else t
        met = met if met < leave else leave
        facet = 2 * ((((cx ^ mx) & mask) << bits) + ((cy ^ my) & mask)) + (np.int64(on) ^ (1 + mx))
        nx, ny = cx + np.int64(along_x), cy + np.int64(not along_x)
        wider = (((nx ^ cx) | (ny ^ cy)) >> (BASE + STEP) != 0) & (bits >= BASE + STEP)
        size, side = BASE + STEP if wider else BASE, FREE + np.int64(not out)
        _put(s, T + k, (met if hit else leave) if live else t)
        _put(q, CX + k, nx if live & (not hit) else cx)
        _put(q, CY + k, ny if live & (not hit) else cy)
        _put(q, SIZE + k, (HIT if hit else size) if live else old)
        _put(q, SIDE + k, (facet if hit else side) if live else known)


@_inner
def _corners(
    z: Singles, cx: int, cy: int, mx: int, my: int, bits: int, used: bool
) -> tuple[float, float, float, float]:  # pragma: no cover
    """Heights at (u, v) = (0, 0), (1, 0), (0, 1), (1, 1); those of cell 0 for a lane that has no use for them."""
    mask = (1 << bits) - 1 if used else 0
    i0, i1 = (((cx ^ mx) - mx) & mask) << bits, (((cx ^ mx) + 1 + mx) & mask) << bits
    j0, j1 = ((cy ^ my) - my) & mask, ((cy ^ my) + 1 + my) & mask
    z00, z10, z01, z11 = _look(z, i0 + j0), _look(z, i1 + j0), _look(z, i0 + j1), _look(z, i1 + j1)
    return np.float64(z00), np.float64(z10), np.float64(z01), np.float64(z11)


@_inner
def _slopes(side: bool, flip: bool, z00: float, z10: float, z01: float, z11: float) -> tuple[float, float]:  # pragma: no cover
    b = z10 - z00 if side != flip else z11 - z01
    c = z11 - z10 if side else z01 - z00
    return b, c


@_inner
def _fetch(
    fetched: Array, starts: Integers, o: Array, d: Array, own: Integers, order: Integers, first: int, last: int
) -> None:  # pragma: no cover
    """Copy up to LANES rays next to each other: many reads of distant memory at once cost little more than one."""
    for k in range(min(last - first, LANES)):
        ray = _look(order, first + k) if len(order) else first + k
        _put(starts, k, _look(own, ray) if len(own) else -1)
        for axis in range(3):
            _put(fetched, axis * LANES + k, _look(o, 3 * ray + axis))
            _put(fetched, (3 + axis) * LANES + k, _look(d, 3 * ray + axis))


@_inner
def _prepare(
    s: Array, q: Integers, fetched: Array, starts: Integers, held: bool, z: Singles, bits: int, top: int, highest: float
) -> None:  # pragma: no cover
    """What the fetched rays put into lanes: if they start on facets, off these already, as all of them have to get there."""
    _enter(s, q, fetched, starts, z, bits, top, highest)
    if held:
        _pass_cells(s, q, z, bits)


@_exact
def _enter(
    s: Array, q: Integers, fetched: Array, starts: Integers, z: Singles, bits: int, top: int, highest: float
) -> None:  # pragma: no cover
    """The state with which the fetched rays enter lanes: a HIT already if a ray points into its own facet or is no ray."""
    _wide()
    for k in range(LANES):
        x, y, oz = _look(fetched, k), _look(fetched, LANES + k), _look(fetched, 2 * LANES + k)
        dx, dy, dz = _look(fetched, 3 * LANES + k), _look(fetched, 4 * LANES + k), _look(fetched, 5 * LANES + k)
        mx, my = -1 if dx < 0.0 else 0, -1 if dy < 0.0 else 0
        sx, sy = -1.0 if dx < 0.0 else 1.0, -1.0 if dy < 0.0 else 1.0
        x, dx, y, dy = sx * x, abs(dx), sy * y, abs(dy)
        good = _is_ray(x, y, oz, dx, dy, dz)
        x, y, dx, dy, dz = x if good else 0.0, y if good else 0.0, dx if good else 1.0, dy if good else 1.0, dz if good else 1.0
        end = REACH / (dx + dy)
        end = end if end < LARGEST else LARGEST
        level = (highest - oz + MARGIN * (abs(highest) + abs(oz))) / (dz + 0.0)  # -0 + 0 is 0
        t = level if (dz < 0.0) & (level > 0.0) else 0.0
        done = level if (dz >= 0.0) & (level < end) else end
        near = t if t < end else end
        cx, cy = np.int64(math.floor(x + near * dx)), np.int64(math.floor(y + near * dy))
        own = _look(starts, k)
        held = (own >= 0) & good
        ox, oy = _near((own >> (bits + 1)) ^ mx, x, bits), _near(((own >> 1) & ((1 << bits) - 1)) ^ my, y, bits)
        inside = (own >> (2 * bits + 1) == 0) & (abs(x - ox - 0.5) <= 0.5 + 1e-6) & (abs(y - oy - 0.5) <= 0.5 + 1e-6)
        side, flip = (own & 1) ^ (1 + mx), mx != my
        b, c = _slopes(side != 0, flip, *_corners(z, ox, oy, mx, my, bits, held))
        blocked = held & (dz - b * dx - c * dy <= 0.0)
        astray = (not good) | (held & (not inside))
        start = START if top > START else top
        ix, iy = 1.0 / dx, 1.0 / dy
        _put(s, T + k, 0.0 if held else t)
        _put(s, FX + k, x)
        _put(s, FY + k, y)
        _put(s, OZ + k, oz)
        _put(s, DX + k, dx)
        _put(s, DY + k, dy)
        _put(s, DZ + k, dz)
        _put(s, IX + k, ix if ix < LARGEST else LARGEST)
        _put(s, IY + k, iy if iy < LARGEST else LARGEST)
        _put(s, END + k, done)
        _put(s, IA + k, 1.0 / (dx + dy if flip else dx - dy))
        _put(q, CX + k, ox if held else cx)
        _put(q, CY + k, oy if held else cy)
        _put(q, MX + k, mx)
        _put(q, MY + k, my)
        _put(q, SIZE + k, HIT if astray | blocked else (CELLS if held else start))
        _put(q, SIDE + k, ASTRAY if astray else (own if blocked else (side if held else -1)))


@_inner
def _is_ray(x: float, y: float, oz: float, dx: float, dy: float, dz: float) -> bool:  # pragma: no cover
    length = dx if dx > dy else dy
    length = length if length > abs(dz) else abs(dz)
    total = x + y + oz + dx + dy + dz
    near = (abs(x) <= REACH) & (abs(y) <= REACH) & (abs(oz) <= REACH)
    return near & (total == total) & (length > TINY) & (length < 1.0 / TINY)


@_inner
def _near(cell: int, x: float, bits: int) -> int:  # pragma: no cover
    """The repetition of a cell that is nearest to x."""
    return cell + (math.floor((x - cell - 0.5) / (1 << bits) + 0.5) << bits)


@_njit(_nrt=False)
def _trace(
    z: Singles,
    words: Integers,
    unit: float,
    slope: float,
    bits: int,
    top: int,
    highest: float,
    o: Array,
    d: Array,
    own: Integers,
    order: Integers,
    facet: Integers,
    distance: Array,
    first: int,
    last: int,
    s: Array,
    q: Integers,
    fetched: Array,
    starts: Integers,
    new_s: Array,
    new_q: Integers,
    found: Integers,
    far: Array,
) -> bool:  # pragma: no cover
    """The rays first..last-1 of the order, in lanes that are filled again when enough are done; whether some are no rays."""
    _reset(q)
    following, count, empty, astray = 0, last - first, -1, False
    while (following < count) | (empty != -1):
        blocks, cells = _census(q)
        busy = blocks | cells
        waiting = _bits(cells)
        if (busy != 0) & (_bits(busy if following < count else busy | empty) > LANES - SPARE):
            if (blocks != 0) & (waiting < MANY):
                _pass_blocks(s, q, words, unit, slope, bits, top)
            else:
                _pass_cells(s, q, z, bits)
            continue
        done = ~(busy | empty)
        while done != 0:
            astray |= _decide(s, q, _lowest(done), highest, found, far)
            done &= done - 1
        empty = ~busy
        while (empty != 0) & (following < count):
            place = following % LANES
            if place == 0:
                _fetch(fetched, starts, o, d, own, order, first + following, last)
                _prepare(new_s, new_q, fetched, starts, len(own) > 0, z, bits, top, highest)
            _fill(s, q, _lowest(empty), new_s, new_q, place, following)
            empty &= empty - 1
            following += 1
    if len(order):
        _return(facet, distance, found, far, order, first, last)
    return astray


@_inner
def _reset(q: Integers) -> None:  # pragma: no cover
    """Lanes without rays."""
    for k in range(7 * LANES):
        q[k] = 0
    for k in range(LANES):
        q[SIZE + k] = GONE


@_exact
def _census(q: Integers) -> tuple[np.int64, np.int64]:  # pragma: no cover
    """Which lanes pass blocks, and which wait for a step through cells: a bit each, that of lane k worth 2^k."""
    _wide()
    blocks, cells = np.int64(0), np.int64(0)
    for k in range(LANES):
        blocks |= np.int64(_get(q, SIZE + k) >= BASE) << k
        cells |= np.int64(_get(q, SIZE + k) == CELLS) << k
    return blocks, cells


@_inner
def _decide(s: Array, q: Integers, k: int, highest: float, found: Integers, far: Array) -> bool:  # pragma: no cover
    """Write what the ray of lane k has met; whether it is no ray. Without a branch: no processor guesses which rays hit."""
    ray, hit, side = _get(q, RAY + k), _get(q, SIZE + k) == HIT, _get(q, SIDE + k)
    t, dz, oz = _get(s, T + k), _get(s, DZ + k), _get(s, OZ + k)
    nothing = LOST + np.int64((dz >= 0.0) & (oz + t * dz > highest))
    _put(found, ray, side if hit else nothing)
    _put(far, ray, t if hit else math.inf)
    return side == ASTRAY


@_inner
def _fill(s: Array, q: Integers, k: int, new_s: Array, new_q: Integers, place: int, ray: int) -> None:  # pragma: no cover
    """Put a ray into lane k."""
    for row in range(0, 11 * LANES, LANES):
        _put(s, row + k, _get(new_s, row + place))
    for row in range(0, 7 * LANES, LANES):
        _put(q, row + k, _get(new_q, row + place))
    _put(q, RAY + k, ray)


@_inner
def _return(
    facet: Integers, distance: Array, found: Integers, far: Array, order: Integers, first: int, last: int
) -> None:  # pragma: no cover
    """Hand results back to where their rays came from."""
    for k in range(last - first):
        ray = _look(order, first + k)
        _put(facet, ray, _get(found, k))
        _put(distance, ray, _get(far, k))


def trace_rays(*job: Any) -> bool:
    """`_trace` with memory that belongs to the thread; results of rays in their own order go where they belong at once."""
    if not hasattr(_thread, "memory"):
        _thread.memory = _memory()
    *_, order, facet, distance, first, last = job
    results = _thread.memory[-2:] if len(order) else (facet[first:last], distance[first:last])
    astray: bool = _trace(*job, *_thread.memory[:-2], *results)
    return astray


def _memory() -> tuple[Any, ...]:
    """Memory for `_trace`: the lanes' state, the next rays, as given and as state, the results."""
    return (
        np.empty(END + LANES),
        np.empty(SIDE + LANES, np.int64),
        np.empty(6 * LANES),
        np.empty(LANES, np.int64),
        np.empty(END + LANES),
        np.empty(SIDE + LANES, np.int64),
        np.empty(CHUNK, np.int64),
        np.empty(CHUNK),
    )
