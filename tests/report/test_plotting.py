"""What figures are drawn with: places, order and limits of what is put on the axes, and texts in each other's way."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.patches import FancyArrowPatch, Polygon
from report import plotting

SCRIPT = str(Path(__file__).parents[2] / "figures" / "visibility" / "masking.py")


@pytest.fixture
def ax() -> Iterator[Any]:
    figure, ax = plotting.canvas(SCRIPT, 2.5)
    yield ax
    plotting.plt.close(figure)


def test_a_canvas_is_as_wide_as_the_text(ax: Any, tmp_path: Path) -> None:
    assert plotting.WIDTH == 6
    assert ax.figure.get_size_inches().tolist() == [6, 2.5]
    with pytest.raises(FileNotFoundError, match=r"no report\.mplstyle in any folder above"):
        plotting.canvas(str(tmp_path / "figure.py"), 1.0)


def test_a_scene_has_one_scale_its_limits_and_no_frame(ax: Any) -> None:
    assert plotting.scene(ax, x=(-1, 2), z=(-3, 4)) is ax
    assert (ax.get_xlim(), ax.get_ylim(), ax.get_aspect(), ax.axison) == ((-1, 2), (-3, 4), 1, False)
    assert len(ax.get_xticks()) == len(ax.get_yticks()) == 0


def test_ground_is_filled_below_its_line(ax: Any) -> None:
    x, z = np.array([0.0, 1.0, 3.0]), np.array([0.5, -0.25, 0.75])
    plotting.ground(ax, x, z, depth=2.0)
    (patch,), (line,) = ax.patches, ax.lines
    assert isinstance(patch, Polygon)
    assert patch.get_xy()[:-1].tolist() == [[0, 0.5], [1, -0.25], [3, 0.75], [3, -2], [0, -2]]
    assert line.get_xydata().tolist() == np.stack([x, z], axis=-1).tolist()
    plotting.ground(ax, x, z, depth=2.0, nodes=True, color="red")
    assert [one.get_marker() for one in ax.lines] == ["None", "None", "."]
    assert ax.lines[2].get_xydata().tolist() == line.get_xydata().tolist()
    assert (ax.lines[1].get_color(), line.get_color()) == ("red", plotting.COLOURS["ink"])


def test_arrows_end_where_they_are_sent(ax: Any) -> None:
    plotting.arrow(ax, (0.0, 1.0), (2.0, 3.0), color="red")
    (patch,) = ax.patches
    assert isinstance(patch, FancyArrowPatch)
    assert patch._posA_posB == [(0, 1), (2, 3)]
    assert (patch.shrinkA, patch.shrinkB) == (0, 0)
    assert to_hex(patch.get_edgecolor()) == "#ff0000"


def test_labels_and_boxes_stand_where_they_are_put(ax: Any) -> None:
    text = plotting.label(ax, (0.25, 0.5), "here", va="top")
    assert (text.get_position(), text.get_text()) == ((0.25, 0.5), "here")
    assert (text.get_ha(), text.get_va()) == ("center", "top")
    box = plotting.box((1.0, 2.0), 3.0, 4.0)
    assert (box.get_x(), box.get_y(), box.get_width(), box.get_height()) == (1, 2, 3, 4)


def test_what_is_said_lies_above_what_is_shown(ax: Any) -> None:
    """Filling, line, pieces, nodes, arrows, and texts, frames and verdicts on top."""
    plotting.ground(ax, [0, 1], [0, 0], 1.0, nodes=True)
    plotting.pieces(ax, np.array([[[0, 0], [1, 1]]]), ["red"])
    plotting.arrow(ax, (0, 0), (1, 1))
    plotting.verdict(ax, (0, 0), holds=True)
    filling, arrow = ax.patches
    line, nodes, piece, tick = ax.lines
    text = plotting.label(ax, (0, 0), "a")
    order = [one.get_zorder() for one in (filling, line, piece, nodes, arrow, text)]
    assert (np.diff(order) > 0).all()
    assert tick.get_zorder() == text.get_zorder() == plotting.box((0, 0), 1, 1).get_zorder()


def strokes(ax: Any) -> list[np.ndarray]:
    return [(line.get_xydata() - [0.5, 0.25]) / 0.1 for line in ax.lines]


def test_a_tick_dips_and_rises(ax: Any) -> None:
    plotting.verdict(ax, (0.5, 0.25), holds=True, size=0.1)
    (line,) = strokes(ax)
    left, low, right = line
    assert line[:, 0].min() == pytest.approx(-1) == left[0]
    np.testing.assert_allclose(right, [1, 1])
    assert left[0] < low[0] < 0 < right[0]
    assert -1 < low[1] < left[1] == pytest.approx(0)
    assert ax.lines[0].get_color() == plotting.COLOURS["green"]


def test_a_cross_has_both_diagonals(ax: Any) -> None:
    plotting.verdict(ax, (0.5, 0.25), holds=False, size=0.1)
    found = sorted(sorted(map(tuple, line.round(9))) for line in strokes(ax))
    assert found == [[(-1, -1), (1, 1)], [(-1, 1), (1, -1)]]
    assert {line.get_color() for line in ax.lines} == {plotting.COLOURS["lost"]}


def test_pieces_of_no_length_are_left_out(ax: Any) -> None:
    ends = np.array([[[0, 0], [1, 2]], [[3, 3], [3, 3]], [[1, 1], [1, 2]]], float)
    plotting.pieces(ax, ends, ["red", "green", "blue"])
    assert [line.get_xydata().tolist() for line in ax.lines] == [ends[0].tolist(), ends[2].tolist()]
    assert [line.get_color() for line in ax.lines] == ["red", "blue"]


class Recorder:
    """Axes that remember what is drawn on them."""

    def __init__(self) -> None:
        self.calls: dict[str, tuple[tuple[Any, ...], dict[str, Any]]] = {}

    def __getattr__(self, name: str) -> Any:
        return lambda *arguments, **named: self.calls.setdefault(name, (arguments, named))


def test_signed_values_have_bands_on_both_sides_and_one_around_zero() -> None:
    ax = Recorder()
    theta, phi = np.radians([0.0, 45, 90]), np.radians([0.0, 180, 360])
    plotting.hemisphere(ax, theta, phi, np.array([[-9.0, 1.0], [2.0, 9.0]]), top=3.0, signed=True)
    (_, _, filled, levels), named = ax.calls["contourf"]
    assert (filled.min(), filled.max()) == (-3, 3)
    np.testing.assert_allclose(levels, -levels[::-1], atol=1e-15)
    assert levels[7] < 0 < levels[8]
    assert named["cmap"] == "PuOr_r"


def test_a_hemisphere_shows_equal_solid_angles_as_equal_areas() -> None:
    """A disc of radius r holds the cap of the solid angle 2 pi r^2; the view, at the azimuth 0, is on the left."""
    ax = Recorder()
    theta, phi = np.radians([0.0, 30, 60, 90]), np.radians([0.0, 90, 180, 270, 360])
    values = np.arange(12.0).reshape(3, 4)
    plotting.hemisphere(ax, theta, phi, values, top=8.0)
    (x, y, filled, levels), _ = ax.calls["contourf"]
    rings = np.radians([0, 15, 45, 75, 90])
    np.testing.assert_allclose(x**2 + y**2, np.repeat(1 - np.cos(rings)[:, None], 5, axis=1), atol=1e-15)
    turns = np.radians([45, 135, 225, 315, 405])
    np.testing.assert_allclose(x[1:], -np.sqrt(1 - np.cos(rings[1:]))[:, None] * np.cos(turns), atol=1e-15)
    np.testing.assert_allclose(y[1:], np.sqrt(1 - np.cos(rings[1:]))[:, None] * np.sin(turns), atol=1e-15)
    closed = np.hstack([values, values[:, :1]])
    np.testing.assert_allclose(filled, np.minimum(np.vstack([np.full(5, 1.5), closed, closed[-1]]), 8))
    np.testing.assert_allclose(levels, np.arange(16) * 8 / 15)
    rim, _ = ax.calls["plot"]
    np.testing.assert_allclose(np.hypot(*rim), 1)
    np.testing.assert_allclose([rim[0][0], rim[0][-1]], 1)
    limits = ax.calls["set"][1]
    assert limits["xlim"] == limits["ylim"]
    assert limits["xlim"][0] == -limits["xlim"][1] < -1


def test_texts_in_each_others_way_are_named(ax: Any) -> None:
    plotting.scene(ax, (0, 10), (0, 10))
    plotting.label(ax, (5, 5), "one")
    assert plotting.overlaps(ax.figure) == []
    plotting.label(ax, (5.1, 5), "two")
    plotting.label(ax, (5.1, 5), " ")
    plotting.label(ax, (2, 2), "unseen").set_visible(False)
    plotting.label(ax, (40, 5), "three")
    outside, touching = plotting.overlaps(ax.figure)
    assert "'three' leaves the figure" in outside
    assert "'one' touches" in touching
    assert "'two'" in touching


def test_labels_beyond_an_axis_are_not_looked_at(ax: Any) -> None:
    """Matplotlib makes them, and does not draw them; those at the very ends are drawn."""
    ax.set(xticks=[-0.9, 0, 0.5, 1, 1.9], yticks=[])  # which makes the axis longer
    ax.set(xlim=(0, 1), ylim=(0, 1))
    ax.figure.canvas.draw()
    hidden = set(plotting._labels_not_drawn(ax.figure))
    assert [tick.get_loc() for tick in ax.xaxis.get_major_ticks() if tick.label1 in hidden] == [-0.9, 1.9]
    assert {tick.label2 for tick in ax.xaxis.get_major_ticks() if tick.label1 in hidden} < hidden
    ax.axis("off")
    assert len({*plotting._labels_not_drawn(ax.figure)}) == 10


def test_only_three_forms_are_written(ax: Any, tmp_path: Path) -> None:
    with pytest.raises(SystemExit, match=r"as \.svg, \.pdf or \.png, not as a\.jpg"):
        plotting.save(ax.figure, [str(tmp_path / "a.jpg")])
    plotting.save(ax.figure, [str(tmp_path / f"a.{form}") for form in ("svg", "pdf", "png")])
    heads = [(tmp_path / f"a.{form}").read_bytes()[:8] for form in ("svg", "pdf", "png")]
    assert [head.lstrip(b"\x89")[:3] for head in heads] == [b"<?x", b"%PD", b"PNG"]
    for form, words in (
        ("svg", (b"dc:date", b"Matplotlib")),
        ("pdf", (b"CreationDate", b"Creator", b"Producer")),
        ("png", (b"Software",)),
    ):
        assert not any(word in (tmp_path / f"a.{form}").read_bytes() for word in words)
    assert ax.figure.number not in plotting.plt.get_fignums()
