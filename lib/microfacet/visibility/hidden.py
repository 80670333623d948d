"""Smith's Lambda of any distribution, by the panels on which its slopes lie: what the facets beyond the edge of visibility hide."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from math import sqrt
from typing import Any

import numpy as np

from microfacet.geometry.panels import NODES, SQUARES, Panels, rule
from microfacet.kernels import Table

MOST = NODES + 2  # nodes along a side
PLACES, PORTIONS = (tuple(float(x) for n in range(1, MOST + 1) for x in rule(n)[part]) for part in (0, 1))  # of all counts
MAPS = tuple(number for square in SQUARES for row in square for number in row)
HEAD, ROW = 2, 10  # of the table: numbers before the panels, and of each


def table_of(found: Panels) -> Table:
    """Panels as `panels_Lambda` takes them: the scale, then of each the square, ends along u and v, moments, and numbers of nodes.

    A panel of degree d times the line that cuts it is of degree d + 1 up to the edge, then of degree 2 d + 3 beside it. One of
    no degree holds nothing that counts.
    """
    degrees = found.degrees[:, None]
    rows = np.concatenate([found.boxes, found.moments, degrees + 2, (degrees + 1) // 2 + 1], axis=1)[found.degrees > 0]
    return Table([*found.scale, *map(float, rows.ravel())])


@cache
def _hidden_part(D: Callable[..., float]) -> Callable[..., float]:
    """What the hidden part of a panel hides, over sin theta_o: the part where q/cot theta_o exceeds 1, a trapezoid or two.

    g = (g1 + gu u + gv v)/W is the slope along the view less cot theta_o; it is followed along the side of the panel on which it
    changes more, from the edge where it is 0, between the places on the other side where the edge enters and leaves.
    """

    def hidden_part(g1: float, gu: float, gv: float, row: int, p: Any) -> float:
        table = p[1]
        square = int(table[row])
        turned = abs(gu) * (table[row + 2] - table[row + 1]) < abs(gv) * (table[row + 4] - table[row + 3])
        low, high = (table[row + 3], table[row + 4]) if turned else (table[row + 1], table[row + 2])
        first, last = (table[row + 1], table[row + 2]) if turned else (table[row + 3], table[row + 4])
        along, aside = (gv, gu) if turned else (gu, gv)
        enters = min(max(-(g1 + along * low) / aside, first), last) if aside != 0.0 else first
        leaves = min(max(-(g1 + along * high) / aside, first), last) if aside != 0.0 else first
        near, far = min(enters, leaves), max(enters, leaves)
        beside, up = int(table[row + 8]), int(table[row + 9])
        from_beside, from_up = beside * (beside - 1) // 2, up * (up - 1) // 2
        total = 0.0
        for part in range(3):
            start = first if part == 0 else near if part == 1 else far
            size = (near if part == 0 else far if part == 1 else last) - start
            for j in range(from_beside, from_beside + beside if size > 0.0 else from_beside):
                b = start + size * PLACES[j]
                edge = min(max(-(g1 + aside * b) / along, low), high)
                begin = edge if along > 0.0 else low
                width = (high if along > 0.0 else edge) - begin
                for i in range(from_up, from_up + up if width > 0.0 else from_up):
                    a = begin + width * PLACES[i]
                    u, v = (b, a) if turned else (a, b)
                    x = table[0] * (MAPS[9 * square] + MAPS[9 * square + 1] * u + MAPS[9 * square + 2] * v)
                    y = table[1] * (MAPS[9 * square + 3] + MAPS[9 * square + 4] * u + MAPS[9 * square + 5] * v)
                    w = MAPS[9 * square + 6] + MAPS[9 * square + 7] * u + MAPS[9 * square + 8] * v
                    m = 1.0 / sqrt(x * x + y * y + w * w)
                    density = D(-x * m, -y * m, w * m, p[0]) * ((m * m) * (m * m))
                    total += (size * PORTIONS[j]) * (width * PORTIONS[i]) * (g1 + along * a + aside * b) * density
        return total * (table[0] * table[1])

    return hidden_part


@cache
def panels_Lambda(D: Callable[..., float]) -> Callable[..., float]:
    """Lambda(x, y, z, (parameters, table)) of any distribution, given where it is: see `table_of`.

    Of a panel beyond the edge of visibility its moments tell what it hides; one that the edge cuts is integrated anew.
    """
    part = _hidden_part(D)

    def panels_Lambda(x: float, y: float, z: float, p: Any) -> float:
        across = sqrt(x * x + y * y)
        if across == 0.0:
            return 0.0
        table = p[1]
        c, s, cot = x / across, y / across, abs(z) / across
        along_x, along_y = c * table[0], s * table[1]
        total = 0.0
        for k in range((len(table) - HEAD) // ROW):
            row = HEAD + ROW * k
            at = 9 * int(table[row])
            g1 = along_x * MAPS[at] + along_y * MAPS[at + 3] - cot * MAPS[at + 6]
            gu = along_x * MAPS[at + 1] + along_y * MAPS[at + 4] - cot * MAPS[at + 7]
            gv = along_x * MAPS[at + 2] + along_y * MAPS[at + 5] - cot * MAPS[at + 8]
            middle = g1 + 0.5 * (gu * (table[row + 1] + table[row + 2]) + gv * (table[row + 3] + table[row + 4]))
            reach = 0.5 * (abs(gu) * (table[row + 2] - table[row + 1]) + abs(gv) * (table[row + 4] - table[row + 3]))
            if middle >= reach:
                total += c * table[row + 6] + s * table[row + 7] - cot * table[row + 5]
            elif middle > -reach:
                total += part(g1, gu, gv, row, p)
        return max(total, 0.0) / cot

    return panels_Lambda
