"""Smith's Lambda of any distribution, by panels on which its slopes lie: what facets beyond the edge of visibility hide."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from math import sqrt
from typing import Any, NamedTuple

import numpy as np

from microfacet.geometry.panels import NODES, SQUARES, Panels, rule
from microfacet.kernels import Table, Vector

MOST = NODES + 2  # nodes along a side
PLACES, PORTIONS = (tuple(float(x) for n in range(1, MOST + 1) for x in rule(n)[part]) for part in (0, 1))  # of all counts
ROW = 15  # numbers of a panel in the table


class Panelled(NamedTuple):
    """Parameters of `panels_Lambda`: see `table_of`."""

    table: Table


def table_of(found: Panels) -> Table:
    """Panels as `panels_Lambda` takes them, row after row.

    First X, Y and W, whose ratios X/W and Y/W are the slopes, each as a sum of 1, u and v, both from 0 to 1 over the panel; the
    area of the panel in its square times both scales; its moments; and numbers of nodes along both sides. A panel of degree d
    times the line that cuts it is of degree d + 1 up to the edge, then of degree 2 d + 3 beside it. One of no degree holds
    nothing that counts.
    """
    _, low, high, first, last = found.boxes.T[..., None]
    maps = np.array(SQUARES)[found.boxes[:, 0].astype(int)] * [[found.scale[0]], [found.scale[1]], [1.0]]
    one, along, across = np.moveaxis(maps, 2, 0)
    local = np.stack([one + along * low + across * first, along * (high - low), across * (last - first)], axis=2)
    area = (high - low) * (last - first) * (found.scale[0] * found.scale[1])
    degrees = found.degrees[:, None]
    rows = np.concatenate([local.reshape(-1, 9), area, found.moments, degrees + 2, (degrees + 1) // 2 + 1], axis=1)
    return Table(map(float, rows[found.degrees > 0].ravel()))


@cache
def _hidden_part(D: Callable[..., float]) -> Callable[..., float]:
    """What the hidden part of a panel hides, over sin theta_o: the part where g = g1 + gu u + gv v is above 0, trapezoids.

    g/W is the slope along the view less cot theta_o. It is followed along the side of the panel on which it changes more, from
    the edge where it is 0, between the places on the other side where the edge enters and leaves.
    """

    def hidden_part(g1: float, gu: float, gv: float, row: int, p: Any) -> float:
        table = p.model.table
        turned = abs(gu) < abs(gv)
        along, aside = (gv, gu) if turned else (gu, gv)
        enters = min(max(-g1 / aside, 0.0), 1.0) if aside != 0.0 else 0.0
        leaves = min(max(-(g1 + along) / aside, 0.0), 1.0) if aside != 0.0 else 0.0
        near, far = min(enters, leaves), max(enters, leaves)
        beside, up = int(table[row + 13]), int(table[row + 14])
        from_beside, from_up = beside * (beside - 1) // 2, up * (up - 1) // 2
        total = 0.0
        for part in range(3):
            start = 0.0 if part == 0 else near if part == 1 else far
            size = (near if part == 0 else far if part == 1 else 1.0) - start
            for j in range(from_beside, from_beside + beside if size > 0.0 else from_beside):
                b = start + size * PLACES[j]
                edge = min(max(-(g1 + aside * b) / along, 0.0), 1.0)
                begin = edge if along > 0.0 else 0.0
                width = 1.0 - edge if along > 0.0 else edge
                for i in range(from_up, from_up + up if width > 0.0 else from_up):
                    a = begin + width * PLACES[i]
                    u, v = (b, a) if turned else (a, b)
                    x = table[row] + table[row + 1] * u + table[row + 2] * v
                    y = table[row + 3] + table[row + 4] * u + table[row + 5] * v
                    w = table[row + 6] + table[row + 7] * u + table[row + 8] * v
                    m = 1.0 / sqrt(x * x + y * y + w * w)
                    density = D((-x * m, -y * m, w * m), p.ndf) * ((m * m) * (m * m))
                    total += (size * PORTIONS[j]) * (width * PORTIONS[i]) * (g1 + along * a + aside * b) * density
        return total * table[row + 9]

    return hidden_part


@cache
def panels_Lambda(D: Callable[..., float]) -> Callable[..., float]:
    """Lambda(wo, p) of any distribution, given where it is: see `table_of`.

    Of a panel beyond the edge of visibility its moments tell what it hides; one that the edge cuts is integrated anew.
    """
    part = _hidden_part(D)

    def panels_Lambda(wo: Vector, p: Any) -> float:
        x, y, z = wo
        across = sqrt(x * x + y * y)
        if across == 0.0:
            return 0.0
        table = p.model.table
        c, s, cot = x / across, y / across, abs(z) / across
        total = 0.0
        for row in range(0, len(table), ROW):
            g1 = c * table[row] + s * table[row + 3] - cot * table[row + 6]
            gu = c * table[row + 1] + s * table[row + 4] - cot * table[row + 7]
            gv = c * table[row + 2] + s * table[row + 5] - cot * table[row + 8]
            if g1 + min(gu, 0.0) + min(gv, 0.0) >= 0.0:
                total += c * table[row + 11] + s * table[row + 12] - cot * table[row + 10]
            elif g1 + max(gu, 0.0) + max(gv, 0.0) > 0.0:
                total += part(g1, gu, gv, row, p)
        return max(total, 0.0) / cot

    return panels_Lambda
