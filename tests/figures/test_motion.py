"""What moves on the web says what the stills say, has a part for every rule, and rests for those who ask for it."""

from __future__ import annotations

import re
import runpy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pytest
from report import motion, plotting

Compute = Callable[[str], dict[str, Any]]
FIGURES = Path(__file__).parents[2] / "figures"
MOVING = [p for p in sorted(FIGURES.glob("*/*.py")) if "\ndef move(" in p.read_text("utf-8")]
LARGEST = 150_000


def moved(script: Path, compute: Compute) -> str:
    return motion.svg(runpy.run_path(str(script))["move"](compute(f"{script.parent.name}/{script.stem}")))


@pytest.mark.parametrize("script", MOVING, ids=lambda p: p.stem)
def test_every_rule_has_its_part_and_its_keyframes(script: Path, compute: Compute) -> None:
    text = moved(script, compute)
    parts = re.findall(r"^#([\w-]+) \{ animation: (\w+)", text, re.M)
    assert parts
    frames = set(re.findall(r"@keyframes (\w+)", text))
    for gid, name in parts:
        assert text.count(f'<g id="{gid}"') == 1
        assert name in frames
    assert "prefers-reduced-motion: reduce" in text
    assert len(text) < LARGEST


@pytest.mark.parametrize("dpi", [72, 144])
def test_places_are_in_points_from_the_upper_left_corner(dpi: int) -> None:
    """Whatever the resolution is: a figure of 4 by 3 inches has 288 by 216 points."""
    figure = plt.figure(figsize=(4, 3), dpi=dpi)
    axes = figure.add_axes((0, 0, 1, 1), xlim=(0, 4), ylim=(0, 3))
    np.testing.assert_allclose(motion.on_paper(axes, [(0, 3), (4, 0), (1, 2)]), [(0, 0), (288, 216), (72, 72)], atol=1e-9)
    plt.close(figure)


@pytest.mark.parametrize("script", MOVING, ids=lambda p: p.stem)
def test_motion_repeats_byte_by_byte(script: Path, compute: Compute) -> None:
    assert moved(script, compute) == moved(script, compute)


def test_facets_fly_to_where_the_last_still_has_them(compute: Compute) -> None:
    data = compute("geometry/facets_to_circle")
    script = runpy.run_path(str(FIGURES / "geometry/facets_to_circle.py"))
    moves = script["move"](data)
    ax = moves.figure.axes[0]
    ways = motion.on_paper(ax, script["goals"](data)) - motion.on_paper(ax, data["middle"])
    for k, way in enumerate(ways):
        name, values = moves.parts[f"facet-{k}"]
        assert name == "fly"
        np.testing.assert_allclose([float(values[key][:-2]) for key in "xz"], way, atol=0.006)
    plotting.plt.close(moves.figure)


def test_stretching_keeps_rays_and_shares(compute: Compute) -> None:
    data = compute("anisotropy/stretched_view")
    assert np.all(data["kept"])
    assert np.all(data["same"])
    assert np.all(data["percent"] == data["percent"][0])
    assert np.all(data["percent"].sum(axis=1) == 100)
    assert 0 < np.sum(data["free"][0]) < data["free"][0].size
    np.testing.assert_allclose(data["share"].sum(axis=1), 1, atol=1e-13)
    np.testing.assert_allclose(np.tan(np.radians(data["degrees"])), data["stretch"] * np.tan(np.radians(55)))


def test_a_drawing_that_was_written_is_closed(tmp_path: Path, compute: Compute) -> None:
    script = MOVING[0]
    made = runpy.run_path(str(script))["move"](compute(f"{script.parent.name}/{script.stem}"))
    assert made.figure.number in plotting.plt.get_fignums()
    motion.save(made, [str(tmp_path / "a.moving.svg")])
    assert made.figure.number not in plotting.plt.get_fignums()
    assert (tmp_path / "a.moving.svg").read_text("utf-8") == moved(script, compute)


def test_a_rule_without_a_part_is_refused() -> None:
    figure, ax = plotting.plt.subplots()
    ax.plot([0, 1], [0, 1], gid="line")
    moves = motion.Motion(figure, {"go": "100% { opacity: 0 }"})
    moves.follow("line", "go")
    assert "#line { animation: go" in motion.svg(moves)
    moves.follow("nothing", "go")
    with pytest.raises(ValueError, match="'nothing'"):
        motion.svg(moves)
    plotting.plt.close(figure)
