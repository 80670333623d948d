"""Who is nearer to what was measured, and when nobody is."""

from __future__ import annotations

import numpy as np
import pytest
from report.contest import contest


def test_a_contest_names_the_nearer_one_or_nobody() -> None:
    found = {
        "names": np.array([["A", "B"]]),
        "alpha": np.array([0.4]),
        "theta_o": np.array([0.0, 60.0, 80.0]),
        "noise": np.zeros((1, 3)),
        "albedo": np.array([[[0.9, 0.001], [0.8, 0.001], [0.7, 0.01]]]),
        "model_albedo": np.array([[[0.9, 0.9], [0.801, 0.79], [0.72, 0.69]]]),
        "distance": np.array([[[[0, 0], [0, 0]], [[0.1, 0.001], [0.05, 0.001]], [[0.1, 0.03], [0.05, 0.03]]]]),
    }
    rows = contest(found, "A", "B", least=30)
    assert [row[1] for row in rows] == ["60°", "80°"]
    assert [row[5] for row in rows] == ["A", "–"]
    assert [row[8] for row in rows] == ["B", "–"]
    assert rows[0][2:5] == ["0.8000 ± 0.0010", "+0.0010", "-0.0100"]


@pytest.mark.parametrize(
    ("off", "error", "light"),
    [
        ([0.01, 0.05], 0.019, "A"),  # both too bright: what is measured drops out
        ([0.05, 0.01], 0.5, "B"),
        ([-0.01, -0.05], 0.5, "A"),
        ([-0.01, 0.05], 0.0099, "A"),  # on either side: two errors, twice each, decide
        ([-0.01, 0.05], 0.0101, "–"),
        ([-0.05, 0.01], 0.0099, "B"),
        ([0.02, 0.02], 0.0, "–"),
    ],
)
def test_who_is_nearer_in_light_depends_on_the_error(off: list[float], error: float, light: str) -> None:
    rows = contest(contested(off, error, [[0.1, 0.0], [0.2, 0.0]]), "A", "B")
    assert rows[0][5] == light


@pytest.mark.parametrize(
    ("errors", "nearer"),
    [([0.0, 0.049], "A"), ([0.0, 0.051], "–"), ([0.03, 0.039], "A"), ([0.03, 0.041], "–"), ([0.051, 0.0], "–")],
)
def test_who_is_nearer_in_shape_depends_on_both_errors(errors: list[float], nearer: str) -> None:
    found = contested([0, 0], 0.0, [[0.1, errors[0]], [0.2, errors[1]]])
    assert contest(found, "A", "B")[0][8] == nearer
    turned = {**found, "names": np.array([["B", "A"]])}
    assert contest(turned, "B", "A")[0][8] == nearer.replace("A", "B")


def contested(off: list[float], error: float, distance: list[list[float]]) -> dict[str, np.ndarray]:
    return {
        "names": np.array([["A", "B"]]),
        "alpha": np.array([0.4]),
        "theta_o": np.array([30.0]),
        "noise": np.zeros((1, 1)),
        "albedo": np.array([[[0.5, error]]]),
        "model_albedo": 0.5 + np.array([[off]]),
        "distance": np.array([[distance]]),
    }
