"""The chart behind a choice: every candidate once, where it belongs, in the look that its legend explains."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from microfacet.enough import chart

DOTS = {
    "cost": np.array([4.0, 2.0, 8.0, np.nan, 3.0, 9.0]),
    "error": np.array([1e-3, 5e-2, 1e-5, 1e-4, 6e-2, 2e-5]),
    "bound": np.array([1e-4, 1e-3, 3e-5, 1e-5, 1e-3, 1e-6]),
    "tolerance": np.array(2e-3),
    "compensation": np.array(["none", "scaled", "walk", "lobe", "none", "scaled"]),
    "verdict": np.array(["within", "beyond", "within", "open", "beyond", "within"]),
    "single": np.array([True, False, False, False, True, True]),
    "chosen": np.array([True, False, False, False, False, False]),
    "measure": "relative to walks",
}
DRAWN = np.maximum(DOTS["error"], DOTS["bound"])


@pytest.fixture
def ax() -> Iterator[Any]:
    ax = Figure().subplots()
    chart.draw(ax, DOTS)
    return ax


def test_the_front_is_what_nothing_beats_in_both() -> None:
    assert chart.front(DOTS["cost"], DRAWN).tolist() == [True, True, True, False, False, True]
    alike = np.array([1.0, 1.0, 2.0])
    assert chart.front(alike, np.array([1.0, 1.0, 1.0])).tolist() == [True, True, False]
    assert chart.front(alike, np.array([2.0, 1.0, 1.0])).tolist() == [False, True, False]


def test_a_line_joins_the_front_and_another_is_the_tolerance(ax: Any) -> None:
    line, tolerance = ax.lines[:2]
    assert line.get_xydata().tolist() == [[2, 5e-2], [4, 1e-3], [8, 3e-5], [9, 2e-5]]
    assert (line.get_linestyle(), tolerance.get_linestyle()) == ("-", "--")
    assert list(tolerance.get_ydata()) == [2e-3, 2e-3]


def test_every_candidate_is_one_dot_with_its_mark_and_its_colour(ax: Any) -> None:
    dots = [line for line in ax.lines if line.get_zorder() == 3 and len(line.get_xdata())]
    found = {
        (float(x), float(y)): (line.get_marker(), line.get_color(), line.get_markerfacecolor())
        for line in dots
        for x, y in line.get_xydata()
        if np.isfinite(x)
    }
    assert len(found) == 5
    for k, cost in enumerate(DOTS["cost"]):
        if np.isfinite(cost):
            colour = chart.COLOURS[DOTS["verdict"][k]]
            inside = "none" if DOTS["single"][k] else colour
            assert found[float(cost), float(DRAWN[k])] == (chart.MARKS[DOTS["compensation"][k]][0], colour, inside)


def test_dots_lie_over_the_ring_of_the_choice_and_that_over_lines(ax: Any) -> None:
    ring = ax.lines[-1]
    assert ring.get_xydata().tolist() == [[4, 1e-3]]
    dot = next(line for line in ax.lines if line.get_zorder() == 3 and 4 in line.get_xdata())
    assert ax.lines[0].get_zorder() < ring.get_zorder() < dot.get_zorder()
    assert ring.get_markersize() > dot.get_markersize()
    assert ring.get_markerfacecolor() == "none"


def test_the_legend_has_what_is_there_once(ax: Any) -> None:
    _, words = ax.get_legend_handles_labels()
    assert words == ["single scattering", "scaled", "lobe added", "random walk", "enough", "not enough", "not known"]
    one = Figure().subplots()
    chart.draw(one, {name: value[:1] if np.ndim(value) else value for name, value in DOTS.items()})
    assert one.get_legend_handles_labels()[1] == ["single scattering", "enough"]
    assert (one.get_xscale(), one.get_yscale(), one.get_ylabel()) == ("log", "log", "error (relative to walks)")


def test_a_chart_without_costs_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="chart needs the candidates' costs, and none is known"):
        chart.save(DOTS | {"cost": np.full(6, np.nan)}, tmp_path / "a.svg")
    chart.save(DOTS, tmp_path / "a.svg")
    assert (tmp_path / "a.svg").read_text("utf-8").count("<svg") == 1
