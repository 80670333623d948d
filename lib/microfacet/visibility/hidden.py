"""Smith's Lambda of any distribution, by panels of slope space: the hidden area of facets beyond the edge of visibility."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from math import sqrt
from typing import Any, NamedTuple

import numpy as np

from microfacet.compiler.kernels import Table, Vector
from microfacet.geometry.panels import SIDE_NODES, SQUARES, Panels, rule

MOST_NODES = SIDE_NODES + 2  # nodes along a side of a panel
NODES, WEIGHTS = (tuple(float(x) for n in range(1, MOST_NODES + 1) for x in rule(n)[part]) for part in (0, 1))  # of all rules
ROW = 15  # numbers per panel in the table


class Panelled(NamedTuple):
    """Parameters of `panels_Lambda`: see `table_of`."""

    table: Table


def table_of(panels: Panels) -> Table:
    """Panels as the table of `panels_Lambda`, row after row.

    A row begins with the coefficients of 1, u and v in X, Y and W, whose ratios X/W and Y/W are the slopes; u and v run from 0
    to 1 over the panel. Then follow the area of the panel in its square times both scales, its moments, and the numbers of
    nodes along both sides: a panel of degree d, times the line that cuts it, has the degree d + 1 along the first side up to
    the edge of visibility, and then 2 d + 3 along the other. Panels of degree 0 are negligible and left out.
    """
    _, low, high, first, last = panels.boxes.T[..., None]
    maps = np.array(SQUARES)[panels.boxes[:, 0].astype(int)] * [[panels.scale[0]], [panels.scale[1]], [1.0]]
    one, along, across = np.moveaxis(maps, 2, 0)
    local = np.stack([one + along * low + across * first, along * (high - low), across * (last - first)], axis=2)
    area = (high - low) * (last - first) * (panels.scale[0] * panels.scale[1])
    degrees = panels.degrees[:, None]
    rows = np.concatenate([local.reshape(-1, 9), area, panels.moments, degrees + 2, (degrees + 1) // 2 + 1], axis=1)
    return Table(map(float, rows[panels.degrees > 0].ravel()))


@cache
def hidden_area_of_panel(D: Callable[..., float]) -> Callable[..., float]:
    """The hidden area of a panel over sin theta_o: an integral over the trapezoids where g = g1 + gu u + gv v is above 0.

    g/W is the slope along the view less cot theta_o. The inner integral runs along the side of the panel on which g changes
    more, from the edge where it is 0; the outer one is split where the edge enters and leaves the panel.
    """

    def hidden_area_of_panel(g1: float, gu: float, gv: float, row: int, p: Any) -> float:
        table = p.model.table
        swapped = abs(gu) < abs(gv)
        along, aside = (gv, gu) if swapped else (gu, gv)
        enters = min(max(-g1 / aside, 0.0), 1.0) if aside != 0.0 else 0.0
        leaves = min(max(-(g1 + along) / aside, 0.0), 1.0) if aside != 0.0 else 0.0
        near, far = min(enters, leaves), max(enters, leaves)
        beside, above = int(table[row + 13]), int(table[row + 14])
        from_beside, from_above = beside * (beside - 1) // 2, above * (above - 1) // 2
        total = 0.0
        for part in range(3):
            start = 0.0 if part == 0 else near if part == 1 else far
            size = (near if part == 0 else far if part == 1 else 1.0) - start
            for j in range(from_beside, from_beside + beside if size > 0.0 else from_beside):
                b = start + size * NODES[j]
                edge = min(max(-(g1 + aside * b) / along, 0.0), 1.0)
                begin = edge if along > 0.0 else 0.0
                width = 1.0 - edge if along > 0.0 else edge
                for i in range(from_above, from_above + above if width > 0.0 else from_above):
                    a = begin + width * NODES[i]
                    u, v = (b, a) if swapped else (a, b)
                    x = table[row] + table[row + 1] * u + table[row + 2] * v
                    y = table[row + 3] + table[row + 4] * u + table[row + 5] * v
                    w = table[row + 6] + table[row + 7] * u + table[row + 8] * v
                    m = 1.0 / sqrt(x * x + y * y + w * w)
                    density = D((-x * m, -y * m, w * m), p.ndf) * ((m * m) * (m * m))
                    total += (size * WEIGHTS[j]) * (width * WEIGHTS[i]) * (g1 + along * a + aside * b) * density
        return total * table[row + 9]

    return hidden_area_of_panel


@cache
def panels_Lambda(D: Callable[..., float]) -> Callable[..., float]:
    """Lambda(wo, p) of any distribution, given its panels: see `table_of`.

    The hidden area of a panel beyond the edge of visibility follows from its moments; a panel that the edge cuts is integrated.
    """
    hidden_area = hidden_area_of_panel(D)

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
                total += hidden_area(g1, gu, gv, row, p)
        return max(total, 0.0) / cot

    return panels_Lambda
