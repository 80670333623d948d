"""The error told of a seen area bounds how far it is off, of functions that jump, bend, or have narrow lobes."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from microfacet.validation import adaptive
from microfacet.validation.adaptive import seen_area
from seen_areas import KINDS, Hostile, disc, gaussian, hostile, mixed, of_normals

CLOSED = 1e-14  # relative, of the closed forms


def off_over_error(case: Hostile, most: int) -> tuple[float, float]:
    """How far off over the error told, and that over the value."""
    found = seen_area(case.D, case.wo, case.G1, most=most)
    off = max(abs(found.value - case.area) - CLOSED * case.area, 0)
    return off / found.error, found.error / found.value


def outside(cases: Iterator[Hostile], most: int) -> list[str]:
    """Those off by more than told; and it says how far the others are from that."""
    found = [(case, *off_over_error(case, most)) for case in cases]
    for kind in KINDS:
        ratios, errors = np.array([rest for case, *rest in found if case.name == kind]).T
        reached = f"{(errors < 1.2e-12).sum()} of {len(errors)} reach the tolerance"
        print(f"{kind}: off over told, median {np.median(ratios):.1g}, largest {ratios.max():.1g}; {reached}")
    return [f"{case.name} from {case.wo}: {ratio:.3g}" for case, ratio, _ in found if ratio > 1]


def test_the_error_bounds_what_is_off() -> None:
    assert outside(hostile(5 * len(KINDS), 100), 20000) == []


@pytest.mark.slow
@pytest.mark.parametrize(("count", "most"), [(1000, 40000), (200, 300000)])
def test_the_error_bounds_what_is_off_of_many(count: int, most: int) -> None:
    assert outside(hostile(count, count), most) == []


def test_a_bound_a_hundred_times_smaller_is_found_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(adaptive, "ERROR_FACTOR", adaptive.ERROR_FACTOR / 100)
    assert outside(hostile(5 * len(KINDS), 100), 20000) != []


def spots() -> Iterator[Hostile]:
    """A hundredth of the facets in a disc of a radius of a thirtieth of its distance from the origin."""
    for azimuth in np.linspace(0, 2 * np.pi, 12):
        x, y = 1.5 * np.cos(azimuth), 1.5 * np.sin(azimuth)
        parts = [(0.99, 0.0, 0.0, gaussian(0.0, 0.0, 1.0)), (0.01, x, y, disc(x, y, 0.05))]
        density, area = mixed(parts, np.array([0.3, 0.2]))
        yield Hostile("spot", of_normals(density, (1.0, 1.0)), None, np.array([0.3, 0.2, 1]) / np.sqrt(1.13), area)


def test_a_look_finds_spots_between_the_nodes_of_the_first_boxes(monkeypatch: pytest.MonkeyPatch) -> None:
    assert max(off_over_error(case, 40000)[0] for case in spots()) <= 1
    monkeypatch.setattr(adaptive, "_first_boxes", lambda integrand: integrand.boxes())
    assert max(off_over_error(case, 40000)[0] for case in spots()) > 1e6


@pytest.mark.parametrize("places", [np.linspace(0, 1, 2001), np.linspace(0.9, 1.1, 501), np.linspace(-0.1, 0.1, 501)])
def test_coefficients_bound_the_error_of_jumps_bends_and_ramps(places: np.ndarray) -> None:
    nodes, weights, _ = adaptive._rule()
    at, x = np.clip(places, 0, 1), nodes[:, None]
    ramp = 0.05
    until = np.clip(places + ramp, 0, 1)
    kinds = {
        "jump": ((x > places) * 1.0, 1 - at),
        "bend": (np.maximum(x - places, 0), ((1 - np.minimum(places, 1)) ** 2 - np.maximum(-places, 0) ** 2) / 2),
        "ramp": (
            np.clip((x - places) / ramp, 0, 1),
            ((until - places) ** 2 - (at - places) ** 2) / (2 * ramp) + 1 - until,
        ),
    }
    for values, exact in kinds.values():
        error = np.abs(values.T @ weights - exact)
        assert (error <= adaptive._falling(values[None])[0] + 1e-15).all()


def test_neighbours_of_an_error_answer_for_a_part_of_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of half rings seen from above: those of the same half inside and outside, and the other half. Larger ones for more."""
    monkeypatch.setattr(adaptive, "WORTH", 0.01)
    level = adaptive._Rings(lambda m: m[:, 2], None, np.array([0.0, 0.0, 1.0]), (1.0, 1.0))
    boxes = level.boxes()
    errors = np.zeros(len(boxes))
    errors[2] = 1.0
    beside = adaptive._beside(level, boxes, errors)
    assert set(np.flatnonzero(beside)) == {0, 3, 4}
    assert 0 < beside[4] < beside[3] < beside[0] < 0.1


def test_neighbours_across_the_edge_of_a_region(monkeypatch: pytest.MonkeyPatch) -> None:
    """The ring up to the edge of visibility meets all three kinds of arcs beyond it."""
    monkeypatch.setattr(adaptive, "WORTH", 0.01)
    wo = np.array([0.6, 0.0, 0.8])
    tilted = adaptive._Rings(lambda m: m[:, 2], None, wo, (1.0, 1.0))
    boxes = tilted.boxes()
    outermost = np.flatnonzero(boxes[:, 0] == 0)[-2:]
    errors = np.zeros(len(boxes))
    errors[outermost] = 1.0
    found = np.flatnonzero(adaptive._beside(tilted, boxes, errors))
    assert set(boxes[found, 0]) >= {0.0, 1.0, 2.0}
    assert (boxes[found[boxes[found, 0] > 0], 1] == 0).all()
