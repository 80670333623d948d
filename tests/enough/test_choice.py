"""The chooser: what it chooses is enough by another rule, what is cheaper is not, and a broken model is not chosen."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import microfacet as mf
import numpy as np
import pytest
from microfacet.__main__ import main
from microfacet.brdf.compensation import Compensated
from microfacet.enough import candidates, cost
from microfacet.enough.candidates import Candidate, candidates_for
from microfacet.enough.choice import MEASURES, Choice, Row, choice, choose, sampler, sampler_label, walk_error
from microfacet.enough.comparison import Comparison, Measured
from microfacet.enough.lobes import COLUMNS, ROWS, Reference, Ruled, counted, lobe_of, nodes, surface
from microfacet.enough.measures import Error, albedo_error, lobe_error, quotient, sky
from microfacet.enough.scene import Point, Scene

METAL = mf.Conductor(0.2, 3.9)
SCENE = Scene((0.1, 0.4), (0, 70), fresnel=METAL, precision="double")
PRICES = {"implicit": 3.0, "schlick": 4.0, "v_cavity": 5.0, "separable": 6.0, "height": 7.0}
MORE = {"none": 0.0, "scaled": 20.0, "lobe": 25.0, "walk": 1000.0}
WALKS = 1 << 15


def priced(scene: Scene) -> dict[str, float]:
    """Costs as a test wants them: masking, then exact Fresnel, then later bounces make a model dearer."""
    return {
        cost.name_of(one, scene.material): PRICES[one.masking]
        + MORE[one.compensation]
        + (one.fresnel == "exact")
        + (not one.single) / 2
        for one in candidates_for(scene)
    }


@pytest.fixture(scope="module")
def comparison() -> Comparison:
    return Comparison(SCENE, walks=WALKS)


def chosen(comparison: Comparison, measure: str, tolerance: float) -> Choice:
    return choice(comparison, measure, tolerance, priced(comparison.scene))


# --- the choice -----------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_finer_and_independent_rule_agrees(comparison: Comparison) -> None:
    """Albedos by quadrature and by walks of another seed, at roughnesses and angles that the chooser did not look at."""
    tolerance = 0.01
    made = chosen(comparison, "albedo", tolerance)
    assert made.chosen
    assert made.chosen.candidate.compensation in ("scaled", "lobe")
    assert made.failed
    off: dict[Candidate, list[float]] = {row.candidate: [] for row in (made.chosen, made.failed)}
    noise = 0.0
    for point in SCENE.grid(4, 4):
        once = mf.Microfacet(mf.Smith(mf.GGX(point.alpha_x)), METAL)
        truth = mf.RandomWalk(once.model, METAL).albedo_with_error(point.wo, walks=1 << 17, seed=7)
        for one in off:
            brdf = one.brdf(METAL, point)
            whole = brdf if one.compensation == "none" else Compensated(brdf, one.compensation)
            off[one].append(abs(whole.albedo(point.wo) - truth.value))
        noise = max(noise, 3 * float(truth.error))
    assert max(off[made.chosen.candidate]) <= tolerance + noise
    assert max(off[made.failed.candidate]) > tolerance - noise
    assert noise < tolerance / 3


@pytest.mark.slow
@pytest.mark.parametrize("measure", MEASURES)
def test_a_smaller_tolerance_is_never_cheaper(comparison: Comparison, measure: str) -> None:
    costs = []
    for tolerance in np.geomspace(1, 1e-5, 26):
        row = chosen(comparison, measure, tolerance).chosen
        costs.append(row.cost if row else np.inf)
    assert costs == sorted(costs)
    assert len(set(costs)) >= 4  # and it is not always the same one


@pytest.mark.parametrize("measure", MEASURES)
@pytest.mark.parametrize("tolerance", [0.3, 0.03, 0.01])
def test_nothing_cheaper_is_enough(comparison: Comparison, measure: str, tolerance: float) -> None:
    made = chosen(comparison, measure, tolerance)
    assert made.chosen
    assert made.chosen.measured.most <= tolerance
    cheaper = [row for row in made.rows if row.cost < made.chosen.cost]
    assert all(row.measured.most > tolerance for row in cheaper)
    if made.failed:
        assert made.failed in cheaper


def test_none_is_said_to_be_enough_where_none_is(comparison: Comparison) -> None:
    made = chosen(comparison, "lobe", 1e-5)
    assert made.chosen is None
    assert "None of the candidates is known to be enough" in made.summary()
    walk = next(row for row in made.rows if row.candidate.compensation == "walk")
    assert walk.verdict == "open"


def test_a_broken_candidate_is_not_chosen(comparison: Comparison, monkeypatch: pytest.MonkeyPatch) -> None:
    before = chosen(comparison, "albedo", 0.01).chosen
    assert before
    sound = Candidate.evaluate

    def broken(self: Candidate, exact: Any, point: Point) -> Any:
        evaluate = sound(self, exact, point)
        return (lambda wo, wi: 1.03 * evaluate(wo, wi)) if self == before.candidate else evaluate

    monkeypatch.setattr(candidates.Candidate, "evaluate", broken)
    after = chosen(Comparison(SCENE, walks=WALKS), "albedo", 0.01).chosen
    assert after
    assert after.candidate != before.candidate
    assert after.cost > before.cost


def test_costs_decide_between_those_that_are_enough(comparison: Comparison) -> None:
    costs = priced(SCENE)
    before = choice(comparison, "albedo", 0.01, costs).chosen
    assert before
    dear = costs | {cost.name_of(before.candidate, METAL): 1e6}
    after = choice(comparison, "albedo", 0.01, dear).chosen
    assert after
    assert after.candidate != before.candidate


@pytest.mark.slow
def test_one_bounce_needs_no_compensation() -> None:
    made = choice(Comparison(Scene(0.3, (0, 60), bounces="one", precision="double")), "lobe", 1e-6, {})
    assert made.chosen
    assert made.chosen.candidate.masking == "height"
    assert {row.candidate.compensation for row in made.rows} == {"none"}


def test_one_roughness_does_not_do_for_two() -> None:
    scene = Scene(0.4, (0, 60), ratio=4, bounces="one", precision="double")
    made = choice(Comparison(scene), "lobe", 0.01, {})
    assert made.chosen
    assert made.chosen.candidate.anisotropic
    alike = [row for row in made.rows if not row.candidate.anisotropic]
    assert min(row.measured.least for row in alike) > 0.1


@pytest.mark.slow
def test_single_precision_is_not_enough_for_its_own_digits() -> None:
    scene = Scene(0.3, 40.0, bounces="one")
    near, nearer = (choice(Comparison(scene), "lobe", t, priced(scene)).chosen for t in (1e-5, 1e-9))
    assert near
    assert nearer
    assert near.candidate.single
    assert not nearer.candidate.single


# --- what is off, and by how much at most -----------------------------------------------------------------------------------

ZERO = np.zeros((ROWS, COLUMNS))


def lobe(**light: float) -> np.ndarray:
    """A lobe with so much light in the first bin and in the last."""
    made = ZERO.copy()
    made[0, 0], made[-1, -1] = light.get("first", 0), light.get("last", 0)
    return made


def exact(of: np.ndarray) -> Ruled:
    return Ruled(of, of[None])


def known(of: np.ndarray, **more: Any) -> Reference:
    return Reference(np.array([of, of]), "walks", **more)


def test_an_error_of_the_albedo_is_the_difference_of_two_sums() -> None:
    truth, found = known(lobe(first=0.5, last=0.3)), exact(lobe(first=0.1, last=0.4))
    assert albedo_error(found, truth) == pytest.approx((0.3, 0))
    unsure = known(truth.lobe, drawn=0.2, rare=0.1, unknown=0.01)
    assert albedo_error(found, unsure) == pytest.approx((0.3, 0.03))
    rough = Ruled(found.lobe, found.lobe[None] + lobe(first=0.004, last=-0.003))
    assert albedo_error(rough, unsure) == pytest.approx((0.3, 0.037))
    as_rough = known(truth.lobe, once=Ruled(ZERO, lobe(first=0.004, last=-0.003)[None]))
    assert albedo_error(rough, as_rough) == pytest.approx((0.3, 0))


def test_an_error_of_the_lobe_is_what_goes_elsewhere() -> None:
    truth, found = known(lobe(first=0.5, last=0.3)), exact(lobe(first=0.1, last=0.4))
    assert lobe_error(found, truth) == pytest.approx((0.25 / 0.8, 0))
    assert lobe_error(exact(lobe(last=0.8)), known(lobe(first=0.8))) == pytest.approx((1, 0))
    unsure = known(truth.lobe, drawn=0.2, rare=0.1, unknown=0.01, once=Ruled(ZERO, lobe(first=0.004)[None]))
    assert lobe_error(found, unsure) == pytest.approx((0.3125, (0.25 + 0.03 + 0.002) / (0.8 - 0.034) - 0.3125))
    assert lobe_error(found, known(ZERO)) == (0, np.inf)


def test_a_quotient_is_within_its_bound() -> None:
    rng = np.random.default_rng(2)
    for above, below in rng.uniform(0.1, 1, (200, 2)):
        value, bound = quotient(above, 0.05, below, 0.02)
        assert value == above / below
        ends = [abs((above + a) / (below + b) - value) for a in (-0.05, 0.05) for b in (-0.02, 0.02)]
        assert max(ends) == pytest.approx(bound)
    assert quotient(1, 0, 0.1, 0.1).bound == np.inf


def test_places_of_a_sphere_turn_local_directions_to_the_viewer() -> None:
    from microfacet.enough.measures import _axes

    for theta in (0.0, 0.4, 1.3):
        for turn in (0.0, 1.0, 4.0):
            axes = _axes(theta, turn)
            np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-15)
            np.testing.assert_allclose([np.sin(theta), 0, np.cos(theta)] @ axes, [0, 0, 1], atol=1e-15)
            side = np.array([np.cos(turn), np.sin(turn)])
            np.testing.assert_allclose(axes[2], [*(np.sin(theta) * side), np.cos(theta)], atol=1e-15)


@pytest.mark.parametrize("point", [Point(0.3, 0.3, 50, 0), Point(0.5, 0.2, 40, 45)])
def test_a_picture_shows_the_light_of_the_sky(point: Point) -> None:
    """What each place of a ring sends to the viewer, against a mean over samples of the sky."""
    from microfacet.enough.measures import RING_AZIMUTHS, _axes

    scene = Scene(0.5, point.theta, ratio=point.alpha_x / point.alpha_y, bounces="one")
    comparison = Comparison(scene, points=(point,))
    (light,) = comparison._skies
    brdf = mf.Microfacet(mf.Smith(mf.GGX(point.alpha_x, point.alpha_y)))
    wi = brdf.sample(point.wo, np.random.default_rng(6).random((1 << 17, 2)))
    up = wi[:, 2] > 0
    weight = np.zeros(len(wi))
    weight[up] = brdf.evaluate(point.wo, wi[up]) * wi[up, 2] / brdf.pdf(point.wo, wi[up])
    phi = np.radians(point.phi)
    about = np.array([[np.cos(phi), np.sin(phi), 0], [-np.sin(phi), np.cos(phi), 0], [0, 0, 1]])
    for k in range(RING_AZIMUTHS):
        frame = _axes(np.radians(point.theta), 2 * np.pi * k / RING_AZIMUTHS)
        values = weight * sky(wi @ about.T @ frame)
        seen = float((light[k] * comparison.truth[0].lobe).sum())
        assert abs(seen - values.mean()) < 5 * values.std() / np.sqrt(len(values)) + 1e-3 * seen


def test_the_sky_is_what_it_is_said_to_be() -> None:
    toward = np.array([0.6, 0.64, 0.48])
    assert sky(np.array([0.0, -1.0, 0.0])) == pytest.approx(0.3, abs=1e-9)
    assert sky(np.array([0.0, 1.0, 0.0])) == pytest.approx(1 + 5 * np.exp(20 * (0.64 / np.linalg.norm(toward) - 1)))
    assert sky(toward / np.linalg.norm(toward)) == pytest.approx(0.3 + 0.7 * (1 + 0.64 / np.linalg.norm(toward)) / 2 + 5)


def test_a_picture_too_bright_by_a_part_is_off_by_that_part() -> None:
    scene = Scene(0.3, (0, 60), bounces="one", precision="double")
    comparison = Comparison(scene)
    whole = next(one for one in comparison.candidates if one.masking == "height")
    assert comparison.measured(whole, "picture").error == pytest.approx((0, 0), abs=1e-12)
    comparison._lobes[whole] = [Ruled(1.03 * a.lobe, 1.03 * a.lobe[None]) for a in comparison.lobes(whole)]
    error = comparison.measured(whole, "picture").error
    assert error.value == pytest.approx(0.03)
    assert error.bound < 0.01


def test_a_picture_counts_its_rings_by_their_area() -> None:
    """Only the ring at 30 degrees is wrong; its area in the picture goes with the sine of 60."""
    comparison = Comparison(Scene(0.3, (0, 60), bounces="one", precision="double"))
    whole = next(one for one in comparison.candidates if one.masking == "height")
    comparison._lobes[whole] = [
        Ruled(f * a.lobe, f * a.lobe[None])
        for a, f in zip(comparison.lobes(whole), np.where([p.theta == 30 for p in comparison.points], 1.1, 1), strict=True)
    ]
    area = np.sin(np.radians([0, 30, 60, 90, 120]))
    assert comparison.measured(whole, "picture").error.value == pytest.approx(0.1 * area[2] / area.sum())


def test_the_worst_of_all_places_counts(comparison: Comparison) -> None:
    found = comparison._worst([Error(0.3, 0.01), Error(0.2, 0.2), Error(0.31, 0.02), Error(0.1, 0.0)])
    assert found == Measured(Error(0.2, 0.2), pytest.approx(0.29), pytest.approx(0.4))
    assert comparison._worst([Error(0.1, 0.2)]).least == 0


@pytest.mark.parametrize(("alpha", "theta"), [(0.005, 0.0), (0.002, 0.0), (0.005, 30.0), (0.3, 40.0)])
@pytest.mark.parametrize("walks", [2, 16, 1 << 16])
def test_one_bounce_loses_what_its_albedo_lacks(alpha: float, theta: float, walks: int) -> None:
    """However smooth the surface and however few the walks: with mirrors, all that does not leave at once leaves later."""
    made = choose(alpha, theta, 1e-9, precision="double", walks=walks, costs={})
    once = next(row for row in made.rows if row.candidate.masking == "height" and row.candidate.compensation == "none")
    point = Point(alpha, alpha, theta, 0)
    albedo, error = mf.Microfacet(mf.Smith(mf.GGX(alpha))).albedo_with_error(point.wo)
    assert abs(once.measured.error.value - (1 - albedo)) <= once.measured.error.bound + error
    assert once.verdict == "beyond"


@pytest.mark.parametrize("walks", [2, 40, 3000])
def test_few_walks_leave_open_what_many_decide(walks: int) -> None:
    scene = Scene(0.5, 40.0, fresnel=METAL, precision="double")
    few, many = (
        {row.candidate: row.measured for row in choice(Comparison(scene, walks=n), "albedo", 1e-3, {}).rows}
        for n in (walks, 1 << 17)
    )
    for one, found in few.items():
        assert found.least <= many[one].error.value <= found.most or one.compensation == "walk"
        assert found.error.bound > many[one].error.bound


def test_a_verdict_is_open_between_its_bounds(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = Scene(0.3, 40.0, bounces="one", precision="double")
    verdicts = {0.2: "beyond", 0.3: "open", 0.4: "open", 0.5: "within", 0.6: "within"}
    monkeypatch.setattr(Comparison, "measured", lambda self, one, measure: Measured(Error(0.4, 0.1), 0.3, 0.5))
    for tolerance, verdict in verdicts.items():
        made = choice(Comparison(scene), "albedo", tolerance, {})
        assert {row.verdict for row in made.rows} == {verdict}
        assert (made.chosen is None) == (verdict != "within")
    assert "No candidate is cheaper." in made.summary()
    assert made.chosen is made.rows[0]


def row(words: str, error: float, bound: float, cost_: float, verdict: str) -> Row:
    one = Candidate("ggx", words, "mirror", False, "none", False)
    return Row(one, Measured(Error(error, bound), max(error - bound, 0), error + bound), cost_, verdict)


def test_a_choice_says_what_is_undecided() -> None:
    rows = (
        row("implicit", 0.5, 0.01, 1, "beyond"),
        row("schlick", 0.1, 0.2, 2, "open"),
        row("v_cavity", 0.3, 0.01, 3, "beyond"),
        row("height", 0.01, 0.001, 4, "within"),
        row("separable", 0.1, 0.2, 5, "open"),
    )
    made = Choice(Scene(0.3), 0.1, "albedo", rows, "walks")
    assert made.chosen is rows[3]
    assert made.failed is rows[1]
    summary = made.summary()
    assert "Next cheaper, and not known to be enough: GGX, Schlick-Smith" in summary
    assert "Undecided of 1 cheaper candidate: more walks would tell." in summary
    assert summary.endswith("Errors are relative to walks; each is within its bound but for odds of 1e-05.")
    none = Choice(Scene(0.3, normals="beckmann"), 0.1, "albedo", rows[:3] + rows[4:], "surfaces", beyond=Error(0.25, 0.01))
    assert "Undecided of 2 candidates: more surfaces would tell." in none.summary()
    assert "The nearest: GGX, Schlick-Smith" in none.summary()
    assert none.summary().endswith("that model itself is 0.25 ± 0.01 from ray-traced surfaces.")
    assert "Undecided" not in Choice(Scene(0.3), 0.1, "albedo", (rows[0], rows[3]), "walks").summary()


def test_how_far_walks_are_from_surfaces_is_told_at_the_largest_roughness(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = []

    def measured(self: Comparison, one: Candidate, measure: str) -> Measured:
        asked.append((self, one, measure))
        return Measured(Error(0.1, 0.2), 0, 0.3)

    monkeypatch.setattr(Comparison, "measured", measured)
    scene = Scene((0.1, 0.4), (0, 60), ratio=(1, 3), fresnel=METAL)
    assert walk_error(Comparison(scene, 3, 5), "lobe") == (0.1, 0.2)
    ((made, one, measure),) = asked
    assert {point[:2] for point in made.points} == {(0.4, 0.4)}
    assert (made.scene.normals, made.surfaces, made.walks, measure) == ("beckmann", 3, 5, "lobe")
    assert one == Candidate("beckmann", "height", "exact", True, "walk", False)
    assert walk_error(Comparison(replace(scene, normals="beckmann")), "lobe") is None
    walk_error(Comparison(Scene(0.3, bounces="one")), "albedo")
    assert asked[-1][1] == Candidate("beckmann", "height", "mirror", False, "none", False)
    for ratio in (1.01, 2.0):  # of two roughnesses if they differ at all
        walk_error(Comparison(Scene(0.3, ratio=ratio, bounces="one")), "albedo")
        assert asked[-1][1].anisotropic


# --- samplers -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", cost.SAMPLERS)
@pytest.mark.parametrize("ratio", [1.0, 2.5])
def test_the_mean_square_of_weights_is_that_of_samples(name: str, ratio: float) -> None:
    scene = Scene(0.5, 40.0, ratio=ratio, fresnel=METAL, bounces="one", precision="double")
    comparison = Comparison(scene)
    one = next(c for c in comparison.candidates if c.masking == "height" and c.anisotropic == (ratio > 1))
    time, square = sampler(comparison, one, name, {f"ggx.{name}.double": 7.0})
    assert time == 7
    found = []
    for point in comparison.points:
        ndf = mf.GGX(point.alpha_x, point.alpha_y)
        guide = mf.Microfacet(mf.Smith(ndf) if name == "visible" else mf.VCavity(ndf))
        wi = guide.sample(point.wo, np.random.default_rng(3).random((1 << 17, 2)))
        up = wi[:, 2] > 0
        weight = np.zeros(len(wi))
        weight[up] = mf.Microfacet(mf.Smith(ndf), METAL).evaluate(point.wo, wi[up]) * wi[up, 2] / guide.pdf(point.wo, wi[up])
        found.append((weight**2).mean() / weight.mean() ** 2)
    assert square == pytest.approx(max(found), rel=0.02)
    assert square > 1


def test_samplers_rank_by_time_for_a_given_noise() -> None:
    assert sampler_label({"normals": (10.0, 3.0), "visible": (20.0, 1.0)}).startswith("visible normals (20.0 ns, mean")
    assert sampler_label({"normals": (10.0, 1.5), "visible": (20.0, 1.0)}).startswith("all normals (10.0 ns, mean")
    unknown = sampler_label({"normals": (np.nan, 1.5), "visible": (1e9, 1.2)})
    assert unknown == (
        "visible normals (1000000000.0 ns, mean square weight 1.2) before all normals (not timed, mean square weight 1.5)"
    )


def test_a_scene_of_no_light_has_no_weights() -> None:
    made = choose(0.3, 40.0, 1e-3, light=(0, 1e-9), precision="double", costs={})
    assert made.chosen
    assert made.samplers["visible"][1] >= 1
    grazing = choose(0.3, 40.0, 1e-3, light=(89.9999, 90), measure="lobe", precision="double", costs={})
    assert grazing.chosen is None
    assert {row.verdict for row in grazing.rows} <= {"open", "beyond"}


# --- lobes ----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("point", [Point(0.5, 0.5, 40, 0), Point(0.8, 0.2, 60, 30)])
def test_samples_fall_into_the_bins_of_the_rule(point: Point) -> None:
    """A chi-square of drawn directions against the rule: either would have to be wrong for it to fail."""
    scene, model = Scene(0.5, normals="beckmann"), mf.Smith(mf.Beckmann(*point[:2]))
    brdf, count = mf.Microfacet(model), 200_000
    wi = brdf.sample(point.wo, np.random.default_rng(1).random((count, 2)))
    wi = wi[wi[:, 2] > 0]
    found = counted(scene, point, wi, np.ones(len(wi))) * (2 if point.isotropic else 1)
    expected = (
        lobe_of(lambda wo, w: brdf.pdf(wo, w) / np.maximum(w[:, 2], 1e-300), scene, point)
        * count
        * (2 if point.isotropic else 1)
    )
    often = expected > 20
    square = float(((found - expected)[often] ** 2 / expected[often]).sum()) / (2 if point.isotropic else 1)
    many = often.sum() / (2 if point.isotropic else 1)
    assert abs(square - many) < 5 * np.sqrt(2 * many)


@pytest.mark.slow
def test_surfaces_of_mirrors_lose_nothing_and_metal_more_with_each_bounce() -> None:
    point = Point(0.7, 0.7, 60, 0)
    whole, once, metal = (
        surface(Scene(0.7, normals="beckmann", fresnel=f, bounces=b), point, 3)
        for f, b in ((None, "all"), (None, "one"), (METAL, "all"))
    )
    assert abs(whole.lobe.sum() - 1) < 1e-12
    smith = mf.Microfacet(mf.Smith(mf.Beckmann(0.7))).albedo(point.wo)
    assert abs(once.lobe.sum() - smith) < 0.05
    assert METAL.F(1.0) ** 2 < metal.lobe.sum() < METAL.F(1.0) + 0.02


def test_light_from_elsewhere_does_not_count() -> None:
    point, brdf = Point(0.5, 0.5, 30, 0), mf.Microfacet(mf.Smith(mf.GGX(0.5)))
    near, far, whole = (lobe_of(brdf.evaluate, Scene(0.5, light=r), point) for r in ((0, 45), (45, 90), (0, 90)))
    np.testing.assert_allclose(near + far, whole, atol=1e-12)
    assert 0.2 < near.sum() < whole.sum()
    assert whole.shape == (ROWS, COLUMNS)
    assert nodes(point).wi.shape[1] == 3
    assert sky(np.array([0.6, 0.64, 0.48])) > sky(np.array([0.0, -1.0, 0.0])) > 0


# --- costs ----------------------------------------------------------------------------------------------------------------


def test_the_record_is_read_by_name(tmp_path: Path) -> None:
    path = tmp_path / "record.json"
    assert cost.recorded(path) == {}
    row = {"sizes": [10, 1000], "seconds": [[1, 1, 1], [1e-6, 2e-6, 3e-6]]}
    path.write_text(json.dumps({"models": {"rows": {"a": row}}}))
    assert cost.recorded(path) == {"a": pytest.approx(2.0)}
    for torn in ("{", '{"models": {"rows": {"a": {}}}}', "[]"):
        path.write_text(torn)
        with pytest.raises(ValueError, match=r"record\.json is not a record of benchmarks"):
            cost.recorded(path)


def test_every_time_that_a_scene_asks_for_has_a_benchmark() -> None:
    from benchmarks import rivals_models

    for normals in ("ggx", "beckmann"):
        for material in (None, mf.Dielectric(1.3), mf.Conductor(1, 2)):
            scene = Scene(0.3, normals=normals, fresnel=material, ratio=2)
            assert {cost.name_of(one, scene.material) for one in candidates_for(scene)} <= set(rivals_models.METHODS)


def test_times_are_the_least_of_all_rounds(monkeypatch: pytest.MonkeyPatch) -> None:
    """Calls that take longer in some rounds; in nanoseconds for one of so many values."""
    now, calls = [0.0], {"a": 0, "b": 0}

    def call(name: str, seconds: float) -> Any:
        def run() -> None:
            calls[name] += 1
            now[0] += seconds * (1 + (calls[name] % 4))

        return run

    monkeypatch.setattr(cost.time, "perf_counter", lambda: now[0])
    found = cost.timed([("a", call("a", 2e-3)), ("b", call("b", 1e-3))], count=1000)
    assert found == pytest.approx({"a": 2000.0, "b": 1000.0})
    assert calls == {"a": cost.ROUNDS + 1, "b": cost.ROUNDS + 1}


def test_what_is_timed_is_what_is_named() -> None:
    one = Candidate("ggx", "height", "exact", False, "none", True)
    values = cost.evaluation(one, METAL, 50)()
    assert (values.shape, values.dtype) == ((50,), np.float32)
    wo, wi = cost.directions(50, 1, np.float32), cost.directions(50, 2, np.float32)
    np.testing.assert_allclose(values, mf.Microfacet(mf.Smith(mf.GGX(0.3)), METAL).evaluate(wo, wi))
    for name in cost.SAMPLERS:
        density = cost.sampling(name, "ggx", np.float32, 50)()
        assert (density.shape, density.dtype) == ((50,), np.float32)
        assert (density > 0).mean() > 0.9
    up = cost.directions(1 << 16, 3, np.float64)
    np.testing.assert_allclose(np.linalg.norm(up, axis=-1), 1)
    assert up[:, 2].min() > 0.0009
    np.testing.assert_allclose(up.mean(axis=0), [0, 0, 0.5], atol=0.01)
    assert cost.guide("visible", "beckmann", Point(0.2, 0.3, 0, 0)).model.ndf.parameters == (0.2, 0.3)
    assert type(cost.guide("normals", "ggx", Point(0.2, 0.3, 0, 0)).model) is mf.VCavity
    assert cost.name_of(one, METAL) == "ggx.height.conductor.none.single"
    assert cost.name_of(replace(one, fresnel="schlick", single=False), METAL) == "ggx.height.schlick.none.double"


def test_unknown_costs_come_last_and_crudest_first() -> None:
    from microfacet.enough.choice import cheapest_first

    scene = Scene(0.3, precision="double", bounces="one")
    costs = {"ggx.height.mirror.none.double": 2.0, "ggx.separable.mirror.none.double": 1.0}
    assert [one.masking for one, _ in cheapest_first(scene, costs)] == [
        "separable",
        "height",
        "implicit",
        "schlick",
        "v_cavity",
    ]


# --- candidates -------------------------------------------------------------------------------------------------------------


def test_a_ladder_has_every_sensible_form_once() -> None:
    def count(**more: Any) -> int:
        made = candidates_for(Scene(0.3, **more))
        assert len(set(made)) == len(made)
        return len(made)

    assert count(bounces="one", precision="double") == 5
    assert count(bounces="one") == 10
    assert count(precision="double") == 5 + 2 + 1
    assert count() == 2 * (5 + 2) + 1
    assert count(precision="double", fresnel=METAL) == 2 * (5 + 2) + 1
    assert count(precision="double", ratio=2) == count(precision="double", ratio=1.01) == 2 * (5 + 2 + 1)
    assert count(precision="double", normals="beckmann") == 2 * (5 + 2 + 1)
    assert not any(one.single for one in candidates_for(Scene(0.3, precision="double")))


def test_a_candidate_is_made_of_its_parts() -> None:
    point = Point(0.4, 0.1, 30, 0)
    mean = Candidate("ggx", "schlick", "schlick", False, "none", True)
    assert mean.ndf(point).parameters == pytest.approx((0.2, 0.2))
    assert replace(mean, anisotropic=True).ndf(point).parameters == (0.4, 0.1)
    assert mean.reflectance(METAL).parameters[0] == pytest.approx(float(METAL.F(1.0)))
    assert replace(mean, fresnel="exact").reflectance(METAL) is METAL
    assert mean.brdf(METAL, point).model.k == pytest.approx(0.1)
    beckmann = replace(mean, normals="beckmann").brdf(METAL, point).model
    assert beckmann.k == pytest.approx(0.2 * np.sqrt(2 / np.pi))
    assert mean.label == "GGX, Schlick-Smith, Schlick's Fresnel, single scattering, single precision"


# --- the command ----------------------------------------------------------------------------------------------------------

BAD = {
    "--alpha 0.3:0.05": "alpha must be a range from low to high, got 0.3 to 0.05",
    "--alpha 0": "alpha must lie above 0, got 0",
    "--alpha 0.3 --theta 0:90": "theta must lie at or above 0 and below 90 degrees, got 0 to 90",
    "--alpha 0.3 --tolerance 0": "tolerance must be a finite number above 0, got 0.0",
    "--alpha 0.3 --tolerance nan": "tolerance must be a finite number above 0, got nan",
    "--alpha x": "alpha must be a number or low:high, such as 0.05:0.3, got 'x'",
    "--alpha 1:2:3": "alpha must be a number or a range such as (0.1, 0.3), got [1.0, 2.0, 3.0]",
    "--alpha 0.3 --ratio 0.5": "ratio must lie at or above 1, got 0.5",
    "--alpha 0.3 --light 30": "light must be a range of more than one angle, got 30",
    "--alpha 0.3 --normals ward": 'bounces must be "one" for Ward: its class has no facet_kernel to follow light by',
    "--alpha 0.3 --measure size": "measure must be one of albedo, lobe, picture, got 'size'",
    "--alpha 0.3 --fresnel 1,2,3": "fresnel must be an index such as 1.5, or 0.2,3.9 for a conductor, got '1,2,3'",
    "--alpha 0.3 --fresnel -1": "eta must be a finite number above 0, got -1.0",
}


@pytest.mark.parametrize("words", BAD)
def test_a_bad_question_gets_one_sentence(words: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["choose", *words.replace(" -1", "=-1").split()]) == 2
    said = capsys.readouterr()
    assert said.err == BAD[words] + "\n"
    assert not said.out


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"costs": "now"}, "costs must be None or nanoseconds by name, got 'now'"),
        ({"costs": 5}, "costs must be None or nanoseconds by name, got 5"),
        ({"tolerance": "0.01"}, "tolerance must be a number above 0, got '0.01'"),
        ({"measure": ["albedo"]}, r"measure must be one of albedo, lobe, picture, got \['albedo'\]"),
        ({"normals": ["ggx"]}, r"normals must be one of ggx, beckmann, ward, got \['ggx'\]"),
        ({"alpha": "12"}, r"alpha must be a number or a range such as \(0.1, 0.3\), got '12'"),
        ({"alpha": ("0.1", "0.2")}, r"alpha must be a number or a range such as \(0.1, 0.3\), got"),
        ({"surfaces": 1}, "surfaces must be a whole number of at least 2, got 1"),
        ({"surfaces": 0}, "surfaces must be a whole number of at least 2, got 0"),
        ({"surfaces": 2.5}, "surfaces must be a whole number of at least 2, got 2.5"),
        ({"walks": 1}, "walks must be a whole number of at least 2, got 1"),
        ({"walks": "all"}, "walks must be a whole number of at least 2, got 'all'"),
        ({"theta": True}, r"theta must be a number or a range such as \(0.1, 0.3\), got True"),
    ],
)
def test_arguments_that_are_none(given: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        choose(**{"alpha": 0.3, **given})


def test_one_number_may_be_an_array() -> None:
    assert Scene(np.array(0.3)).alpha == Scene(np.array([0.3, 0.3])).alpha == (0.3, 0.3)


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """The command with known costs and a small walk."""
    from microfacet.enough import choice as module

    monkeypatch.setattr(module, "costs_now", lambda comparison: priced(comparison.scene))
    monkeypatch.setattr(module, "walk_error", lambda comparison, measure: None)


@pytest.mark.usefixtures("quick")
def test_the_command_prints_a_table_and_draws(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    chart = tmp_path / "chart.svg"
    assert (
        main(["choose", "--alpha", "0.3", "--theta", "40", "--tolerance", "1e-5", "--bounces", "one", "--chart", str(chart)])
        == 0
    )
    said = capsys.readouterr().out
    assert "Enough: GGX, Smith, height-correlated, no Fresnel, single scattering, single precision: error" in said
    assert said.count("| ✓ within |") == 2
    assert "<svg" in chart.read_text()
    assert main(["choose", "--alpha", "0.3", "--theta", "40", "--bounces", "one", "--chart", "chart.gif"]) == 2
    assert "chart must end in .svg, .pdf or .png" in capsys.readouterr().err


@pytest.mark.usefixtures("quick")
def test_without_matplotlib_there_is_a_sentence(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    assert main(["choose", "--alpha", "0.3", "--theta", "40", "--bounces", "one", "--chart", "chart.svg"]) == 2
    assert capsys.readouterr().err == "chart needs matplotlib, which is not installed\n"
