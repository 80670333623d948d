"""What the campaign measures is what its names and the chapter say; its seeds are its own."""

from __future__ import annotations

from itertools import pairwise, product
from pathlib import Path

import numpy as np
import pytest
from report import campaign
from report.campaign import CAMPAIGN

GOLDEN = 180 * (3 - np.sqrt(5))  # degrees: no turn spreads more evenly


def angles(name: str) -> list[tuple[float, float]]:
    """Polar angle and azimuth of each view, degrees."""
    x, y, z = np.asarray(CAMPAIGN[name].plan.views).T
    return list(zip(np.degrees(np.arccos(z)), np.degrees(np.arctan2(y, x)) % 360, strict=True))


@pytest.mark.parametrize("name", [name for name in CAMPAIGN if name != "stretched"])
def test_a_name_ends_with_the_roughness(name: str) -> None:
    family = CAMPAIGN[name].family
    assert family.alpha_x == family.alpha_y == float(name[-2:]) / 10
    assert CAMPAIGN[name].plan.method == ("gabor" if name.startswith("gabor") else "spectral")


def test_views_are_those_that_figures_name() -> None:
    for name, entry in CAMPAIGN.items():
        if name.startswith(("lobes", "gabor")):
            wanted = campaign.GABOR_THETA_O if name.startswith("gabor") else campaign.THETA_O
            theta, phi = np.transpose(angles(name))
            np.testing.assert_allclose(theta, wanted, atol=1e-6)
            turned = GOLDEN * np.arange(1, len(wanted) + 1) % 360
            np.testing.assert_allclose(phi[theta > 1], turned[theta > 1], atol=1e-9)
        if name.startswith("azimuths"):
            assert angles(name) == [(pytest.approx(60), pytest.approx(np.degrees(0.3)))]
            lights = [np.degrees(one).round(9).tolist() for one in entry.plan.lights]
            assert lights == [[60, 75], [0, 5, 10, 20, 40, 60, 90, 135, 180]]
    np.testing.assert_allclose(angles("stretched"), list(product((40, 60, 80), (0, 45, 90))), atol=1e-6)
    assert campaign.GABOR_THETA_O == (0, 60, 80)
    assert set(campaign.GABOR_THETA_O) <= set(campaign.THETA_O)
    assert campaign.THETA_O == (0, 20, 40, 60, 70, 80)


def test_no_view_from_the_side_looks_along_the_grid() -> None:
    """Nor along its diagonal; stretched surfaces are looked at along their axes, which are the grid's."""
    for name in ("lobes_04", "gabor_07", "azimuths_04"):
        away = [min(phi % 45, 45 - phi % 45) for theta, phi in angles(name) if theta > 1]
        assert min(away) > 2, name


def test_bins_are_two_degrees_by_seven_and_a_half() -> None:
    """So the chapter says; and all entries with lobes can be compared bin by bin."""
    followed = {name for name, entry in CAMPAIGN.items() if entry.plan.bounces}
    assert followed == {name for name in CAMPAIGN if not name.startswith("azimuths")}
    for name in followed:
        theta, phi = (np.degrees(np.diff(edges)) for edges in CAMPAIGN[name].plan.lobe_edges)
        np.testing.assert_allclose(theta, 2)
        np.testing.assert_allclose(phi, 7.5)


def test_families_of_other_surfaces_have_other_seeds() -> None:
    """Lobes and azimuths of one roughness are of the same surfaces; all others are independent."""
    root = {name: entry.family.root for name, entry in CAMPAIGN.items()}
    for name in campaign.ALPHAS:
        assert root[f"lobes_{name}"] == root.pop(f"azimuths_{name}")
    assert all(a != b for a, b in pairwise(sorted(root.values())))


def test_results_are_looked_for_where_the_build_leaves_them(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("MICROFACET_CAMPAIGN", raising=False)
    assert campaign.folder() == Path("build/campaign")
    monkeypatch.setenv("MICROFACET_CAMPAIGN", str(tmp_path))
    np.savez(tmp_path / "gabor_07.npz", seen=np.arange(3.0))
    np.testing.assert_array_equal(campaign.read("gabor_07")["seen"], [0, 1, 2])
    with pytest.raises(ValueError, match=r"name must be one of lobes_04, .*, got 'gabor_7'"):
        campaign.read("gabor_7")
