"""How panels are refined: what is halved, what an error consists of, and when it is over."""

from __future__ import annotations

import numpy as np
import pytest
from microfacet.geometry import panels


class Scripted:
    """In place of sums over a density: the area of a box, errors as large as its sides, and more area once it is halved."""

    def __init__(self, more: float, errors: tuple[float, float]) -> None:
        self.more, self.errors, self.evaluations, self.calls = more, errors, 0, 0

    def __call__(self, boxes: np.ndarray) -> np.ndarray:
        sums = np.zeros((len(boxes), panels.DOUBTS + 1 + panels.SIDE_NODES))
        sides = boxes[:, [2, 4]] - boxes[:, [1, 3]]
        area = sides.prod(axis=1)
        sums[:, 0] = area * (1 + (self.more if self.calls else 0))
        sums[:, 3:5] = area[:, None] * sides * np.array(self.errors)
        self.calls += 1
        self.evaluations += len(boxes) * panels.SIDE_NODES**2
        return sums


ONE = np.array([[0.0, 0.0, 1.0, 0.0, 1.0]])


def test_a_doubt_is_what_halves_do_not_add_up_to_and_is_inherited(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(panels, "ROUNDS", 1)
    boxes, sums = panels._refined(Scripted(0.25, (1.0, 2.0)), ONE, 1e-9)
    np.testing.assert_allclose(sums[:, panels.DOUBTS], [panels.DOUBT * 0.25] * 2)
    monkeypatch.setattr(panels, "ROUNDS", 2)
    boxes, sums = panels._refined(Scripted(0.25, (1.0, 2.0)), ONE, 1e-9)
    assert len(boxes) == 4
    np.testing.assert_allclose(sums[:, panels.DOUBTS], [panels.DOUBT**2 * 0.25] * 4)  # nothing is apart any more


@pytest.mark.parametrize("across", [False, True])
def test_the_side_of_the_larger_error_is_halved(across: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(panels, "ROUNDS", 1)
    boxes, _ = panels._refined(Scripted(0.0, (1.0, 2.0) if across else (2.0, 1.0)), ONE, 1e-9)
    half = [[0, 0, 1, 0, 0.5], [0, 0, 1, 0.5, 1]] if across else [[0, 0, 0.5, 0, 1], [0, 0.5, 1, 0, 1]]
    assert boxes.tolist() == half


@pytest.mark.parametrize("goal", [2.1, 1.9, 0.3, 0.01])
def test_halving_ends_where_all_errors_add_up_to_the_goal(goal: float) -> None:
    """An error of 2 at first, which each halving halves; no more panels than twice as many as are needed."""
    boxes, sums = panels._refined(Scripted(0.0, (2.0, 0.0)), ONE, goal)
    assert sums[:, 3].sum() <= goal
    assert (len(boxes) == 1) == (goal > 2)
    assert len(boxes) <= 4 * max(1, 2 / goal)
    assert sums[:, 0].sum() == pytest.approx(1)


def test_halving_ends_where_no_evaluations_are_left(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(panels, "MOST_EVALUATIONS", 20 * panels.SIDE_NODES**2)
    summed = Scripted(0.0, (2.0, 0.0))
    panels._refined(summed, ONE, 1e-12)
    assert 18 * panels.SIDE_NODES**2 < summed.evaluations <= 20 * panels.SIDE_NODES**2


def test_an_error_is_as_large_as_the_last_coefficients_or_falls_with_their_cube() -> None:
    """As a kink has it, where they are like those before them; as a smooth function has it, where they are far below."""
    random = np.random.default_rng(1)
    shape = random.random((1, 4, 1))
    found = [panels.falling(np.concatenate([shape, last * shape], axis=1))[0, 0] for last in (1.0, 0.5, 1e-2, 1e-3)]
    size = np.sqrt((shape**2).sum())
    np.testing.assert_allclose(found[:2], [size, 0.5 * size])
    assert found[2] / found[3] == pytest.approx(1e3)
    assert found[2] < 1e-2 * 1e-2 * size
