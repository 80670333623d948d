"""The chooser: what it chooses is enough by another rule, what is cheaper is not, and a broken model is not chosen."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import microfacet as mf
import numpy as np
import pytest
from microfacet.__main__ import main
from microfacet.brdf.compensation import Compensated
from microfacet.enough import candidates, cost
from microfacet.enough.candidates import Candidate, ladder
from microfacet.enough.choice import MEASURES, Choice, Comparison, choice, choose, sky
from microfacet.enough.lobes import COLUMNS, ROWS, counted, lobe_of, nodes, surface
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
        for one in ladder(scene)
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
        truth = mf.RandomWalk(once.model, METAL).albedo(point.wo, walks=1 << 17, seed=7)
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
    assert "None of the candidates is known to be enough" in made.told()
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


# --- lobes ----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("point", [Point(0.3, 0.3, 0, 0), Point(0.8, 0.2, 60, 30), Point(0.05, 0.05, 80, 0)])
@pytest.mark.parametrize("kind", [mf.GGX, mf.Beckmann])
def test_the_rule_over_the_bins_is_as_near_as_it_says(point: Point, kind: Any) -> None:
    scene, brdf = Scene(point[:2][::-1]), mf.Microfacet(mf.Smith(kind(*point[:2])))
    albedo, error = brdf.albedo_with_error(point.wo)
    off = abs(lobe_of(brdf.evaluate, scene, point).sum() - albedo)
    assert off <= rule_error(brdf.evaluate, scene, point) + 5 * error + 1e-9
    assert off < 2e-4


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
    import rivals_models

    for normals in ("ggx", "beckmann"):
        for material in (None, mf.Dielectric(1.3), mf.Conductor(1, 2)):
            scene = Scene(0.3, normals=normals, fresnel=material, ratio=2)
            assert {cost.name_of(one, scene.material) for one in ladder(scene)} <= set(rivals_models.METHODS)


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
    "--alpha 0.3 --normals ward": "normals must be one of ggx, beckmann, got 'ward'",
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
        ({"costs": "nwo"}, "costs must be None, 'now', or nanoseconds by name, got 'nwo'"),
        ({"costs": 5}, "costs must be None, 'now', or nanoseconds by name, got 5"),
        ({"tolerance": "0.01"}, "tolerance must be a number above 0, got '0.01'"),
        ({"measure": ["albedo"]}, r"measure must be one of albedo, lobe, picture, got \['albedo'\]"),
        ({"normals": ["ggx"]}, r"normals must be one of ggx, beckmann, got \['ggx'\]"),
        ({"alpha": "12"}, r"alpha must be a number or a range such as \(0.1, 0.3\), got '12'"),
        ({"alpha": ("0.1", "0.2")}, r"alpha must be a number or a range such as \(0.1, 0.3\), got"),
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

    monkeypatch.setattr(module, "known_costs", lambda comparison, now=False: priced(comparison.scene))
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
