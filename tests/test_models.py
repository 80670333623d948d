"""Models can be pickled, copied, compared, and sent to other processes, those of users too."""

from __future__ import annotations

import copy
import multiprocessing
import pickle
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from typing import Any

import microfacet as mf
import numpy as np
import pytest
from microfacet.material.fresnel import Mirror
from microfacet.model import Model
from microfacet.surface.gaussian import GaussianField
from microfacet.surface.height_field import HeightField
from microfacet.validation.equations import Validation, Verdict
from users_models import Linear, Named, Steep, Steeper, same, value

SMITH = mf.Smith(mf.GGX(0.3, 0.1))
MAKERS: dict[str, Callable[[], Model]] = {
    "Beckmann": lambda: mf.Beckmann(0.3),
    "GGX": lambda: mf.GGX(0.3, 0.1),
    "Ward": lambda: mf.Ward(0.3),
    "BlinnPhong": lambda: mf.BlinnPhong(20),
    "NormalizedBlinnPhong": lambda: mf.NormalizedBlinnPhong(20),
    "Smith": lambda: mf.Smith(mf.GGX(0.3, 0.1), correlation="none"),
    "Smith by quadrature": lambda: mf.Smith(Steep(0.5)),
    "VCavity": lambda: mf.VCavity(mf.Beckmann(0.3)),
    "Implicit": lambda: mf.Implicit(mf.GGX(0.3)),
    "Kelemen": lambda: mf.Kelemen(mf.GGX(0.3)),
    "SchlickSmith": lambda: mf.SchlickSmith(mf.GGX(0.3), 0.2),
    "Mirror": lambda: Mirror(),
    "Dielectric": lambda: mf.Dielectric(1.5),
    "Conductor": lambda: mf.Conductor(0.2, 3.9),
    "Schlick": lambda: mf.Schlick(0.04, 0.9),
    "F82Tint": lambda: mf.F82Tint(0.9, 0.7),
    "Microfacet": lambda: mf.Microfacet(mf.Smith(mf.GGX(0.3)), mf.Schlick(0.5)),
    "Diffuse": lambda: mf.Diffuse(mf.Smith(mf.GGX(0.3)), 0.5),
    "Compensated": lambda: mf.Compensated(mf.Microfacet(mf.Smith(mf.GGX(0.3)), mf.Schlick(0.5)), "scaled"),
    "RandomWalk": lambda: mf.RandomWalk(mf.Smith(mf.GGX(0.3)), mf.Dielectric(1.5)),
    "a user's distribution": lambda: Steep(0.5, "mine", samples=[3.0, 4.0]),
    "a user's subclass": lambda: Steeper(0.5),
    "a user's subclass of GGX": lambda: Named(0.5),
    "a user's reflectance": lambda: Linear(0.5),
    "a user's, in a BRDF": lambda: mf.Microfacet(mf.VCavity(Named(0.5)), Linear(0.5)),
}


@pytest.mark.parametrize("name", MAKERS)
def test_equal_arguments_make_equal_models(name: str) -> None:
    first, second = MAKERS[name](), MAKERS[name]()
    assert first == second
    assert hash(first) == hash(second)
    assert len({first, second}) == 1


def test_different_models_differ() -> None:
    made = [make() for make in MAKERS.values()]
    assert len(set(made)) == len(made)
    for k, one in enumerate(made):
        assert all(one != other for other in made[k + 1 :])


@pytest.mark.parametrize("name", MAKERS)
def test_copies_are_equal_and_work(name: str) -> None:
    """Also of a model that has been used, and so has compiled functions by now."""
    model = MAKERS[name]()
    expected = value(model)
    copies = [copy.copy(model), copy.deepcopy(model)]
    copies += [pickle.loads(pickle.dumps(model, protocol)) for protocol in range(2, pickle.HIGHEST_PROTOCOL + 1)]
    for twin in copies:
        assert twin is not model
        assert (type(twin), repr(twin)) == (type(model), repr(model)) or name.startswith("a user's")
        assert twin == model
        assert hash(twin) == hash(model)
        assert value(twin) == expected


def test_arguments_are_compared_by_what_they_mean() -> None:
    assert mf.GGX(0.3) == mf.GGX(0.3, 0.3) == mf.GGX(alpha_x=0.3)
    assert mf.Smith(mf.GGX(0.3)) == mf.Smith(mf.GGX(0.3, 0.3), "height")
    assert mf.SchlickSmith(mf.GGX(0.3)) == mf.SchlickSmith(mf.GGX(0.3), mf.SchlickSmith(mf.GGX(0.3)).k)
    assert mf.Microfacet(SMITH) == mf.Microfacet(SMITH, Mirror())
    assert mf.Dielectric(2) == mf.Dielectric(2.0)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (mf.GGX(0.3), mf.GGX(np.nextafter(0.3, 1))),
        (mf.GGX(0.3), mf.Beckmann(0.3)),
        (mf.GGX(0.3, 0.1), mf.GGX(0.1, 0.3)),
        (mf.BlinnPhong(20), mf.NormalizedBlinnPhong(20)),
        (mf.Smith(mf.GGX(0.3)), mf.Smith(mf.GGX(0.3), "none")),
        (mf.Implicit(mf.GGX(0.3)), mf.Kelemen(mf.GGX(0.3))),
        (mf.Microfacet(SMITH), mf.Microfacet(SMITH, mf.Schlick(1))),
        (Steep(0.5), Steeper(0.5)),
        (Steep(0.5), Steep(0.5, "mine")),
        (Steep(0.5), Steep(0.5, samples=[1.0, 2.5])),
        (mf.GGX(0.3), 0.3),
    ],
)
def test_models_of_other_kinds_or_parameters_differ(one: Any, other: Any) -> None:
    assert one != other


def test_a_model_does_not_follow_an_array_that_it_was_made_of() -> None:
    samples = np.array([1.0, 2.0])
    model = Steep(0.5, samples=samples)
    samples[0] = 7.0
    assert pickle.loads(pickle.dumps(model)) == model == Steep(0.5)


def test_a_class_without_arguments_takes_none() -> None:
    with pytest.raises(TypeError):
        Mirror(3)  # type: ignore[call-arg]


def test_no_compiled_function_is_in_a_pickle() -> None:
    for name, make in MAKERS.items():
        model = make()
        value(model)
        text = pickle.dumps(model)
        assert len(text) < 500, name
        assert not [word for word in (b"numba", b"kernel", b"Batch") if word in text], name


def test_surfaces_and_verdicts_pickle() -> None:
    heights = np.random.default_rng(1).random((8, 8))
    field, twin = HeightField(heights), pickle.loads(pickle.dumps(HeightField(heights)))
    np.testing.assert_array_equal(field.heights, twin.heights)
    rays = np.array([[2.3, 3.1, 5.0]]), np.array([[0.1, 0.2, -1.0]])
    for one, other in zip(field.trace(*rays), twin.trace(*rays), strict=True):
        np.testing.assert_array_equal(one, other)
    surface = GaussianField(size=128, alpha_x=0.3)
    assert pickle.loads(pickle.dumps(surface)) == surface
    found = Validation("GGX", [Verdict("normals", "holds", 1e-9, 1e-8, "30 degrees")])
    assert pickle.loads(pickle.dumps(found)) == copy.deepcopy(found) == found
    assert str(pickle.loads(pickle.dumps(found))) == str(found)


# --- other processes --------------------------------------------------------------------------------------------------

MODELS = [make() for name, make in MAKERS.items() if name != "RandomWalk"]


def expected() -> list[tuple[Any, float]]:
    return [same(model) for model in MODELS]


@pytest.mark.slow
@pytest.mark.parametrize("method", multiprocessing.get_all_start_methods())
def test_pools_of_the_standard_library(method: str) -> None:
    context = multiprocessing.get_context(method)
    with context.Pool(2) as pool:
        assert pool.map(same, MODELS) == expected()
    with ProcessPoolExecutor(2, mp_context=context) as executor:
        assert list(executor.map(same, MODELS)) == expected()


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["loky", "multiprocessing", "threading"])
def test_joblib(backend: str) -> None:
    import joblib

    found = joblib.Parallel(n_jobs=2, backend=backend)(joblib.delayed(same)(model) for model in MODELS)
    assert list(found) == expected()
    assert joblib.hash(mf.GGX(0.3)) == joblib.hash(copy.deepcopy(mf.GGX(0.3)))


@pytest.mark.slow
@pytest.mark.parametrize("scheduler", ["processes", "threads", "synchronous"])
def test_dask(scheduler: str) -> None:
    import dask

    tasks = [dask.delayed(same)(model) for model in MODELS]
    assert list(dask.compute(*tasks, scheduler=scheduler, num_workers=2)) == expected()
