"""Frames are orthonormal and right-handed wherever the normal points, and a BRDF in one does not know where it stands."""

from __future__ import annotations

import pickle

import microfacet as mf
import numpy as np
import pytest
from samples import hemisphere
from scipy.spatial.transform import Rotation

REALS = [np.float64, np.float32]
POLES = [[0, 0, 1], [0, 0, -1], [0, -0.0, -1], [1e-9, 0, -1], [1e-20, 1e-20, -1], [1, 0, 0], [1, 1, -1e-30], [1, 0, -0.0]]


def vectors(count: int, seed: int) -> np.ndarray:
    """In all directions, of lengths from 1e-30 to 1e30."""
    random = np.random.default_rng(seed)
    made = random.normal(size=(count, 3)) * 10.0 ** random.uniform(-30, 30, (count, 1))
    return np.concatenate([made, POLES])


def check(frame: mf.Frame, real: type) -> None:
    axes = np.stack(np.broadcast_arrays(frame.x, frame.y, frame.z), axis=-2)
    assert axes.dtype == real
    eps = np.finfo(real).eps
    products = axes.astype(float) @ np.swapaxes(axes, -1, -2).astype(float)
    np.testing.assert_allclose(products, np.broadcast_to(np.eye(3), products.shape), rtol=0, atol=8 * eps)
    np.testing.assert_allclose(np.linalg.det(axes.astype(float)), 1, rtol=16 * eps)


@pytest.mark.parametrize("real", REALS)
def test_axes_from_a_normal_alone(real: type) -> None:
    normal = vectors(400, 1).astype(real)
    frame = mf.Frame(normal)
    check(frame, real)
    exact = normal.astype(float)
    np.testing.assert_allclose(frame.z, exact / np.linalg.norm(exact, axis=-1, keepdims=True), atol=4 * np.finfo(real).eps)


@pytest.mark.parametrize("real", REALS)
def test_axes_from_normal_and_tangent(real: type) -> None:
    """The tangent lies in the half plane of x and z, also where it is a thousand times nearer to the normal than to x."""
    normal, across = vectors(400, 2).astype(real), hemisphere(408, 3).astype(real)
    for share in (1.0, 1e-3):
        along = mf.Frame(normal).z
        across = np.where(abs(np.sum(across * along, axis=-1, keepdims=True)) > 0.9, mf.Frame(normal).x, across)
        tangent = along + real(share) * across
        frame = mf.Frame(normal, tangent)
        check(frame, real)
        local = frame.to_local(tangent)
        assert (local[..., 0] > 0).all()
        np.testing.assert_allclose(local[..., 1] / local[..., 0], 0, atol=32 * np.finfo(real).eps / share)


@pytest.mark.parametrize("real", REALS)
def test_to_world_undoes_to_local(real: type) -> None:
    frame = mf.Frame(vectors(50, 4).astype(real), hemisphere(58, 5).astype(real))
    w = hemisphere(58, 6).astype(real)
    local = frame.to_local(w)
    assert local.dtype == real
    np.testing.assert_allclose(frame.to_world(local), w, rtol=0, atol=8 * np.finfo(real).eps)
    np.testing.assert_allclose(np.linalg.norm(local, axis=-1), 1, rtol=8 * np.finfo(real).eps)


def test_shapes_broadcast() -> None:
    frame = mf.Frame(hemisphere(12, 1).reshape(3, 4, 3), [1, 0.2, 0])
    assert frame.to_local(hemisphere(5, 2)[:, None, None]).shape == (5, 3, 4, 3)
    assert frame.rotated(np.linspace(0, 1, 4)).x.shape == (3, 4, 3)
    assert mf.Frame([0, 0, 1]).to_local([0, 0.6, 0.8]).shape == (3,)


def test_one_normal_and_many_tangents() -> None:
    """As many frames as tangents, each the same as alone."""
    tangents = mf.spherical(np.radians(70), np.linspace(0, 6, 5))
    w = mf.spherical(0.5, 2.0)
    frame = mf.Frame([0, 0, 1], tangents)
    alone = [mf.Frame([0, 0, 1], tangent).to_local(w) for tangent in tangents]
    np.testing.assert_array_equal(frame.to_local(w), alone)
    np.testing.assert_allclose(frame.to_world(alone), np.broadcast_to(w, (5, 3)), atol=1e-15)


@pytest.mark.parametrize("real", REALS)
def test_rotation_is_about_the_normal_and_adds_up(real: type) -> None:
    frame = mf.Frame(vectors(20, 7).astype(real))
    once, twice = frame.rotated(0.4), frame.rotated(0.4).rotated(0.5)
    check(once, real)
    atol = 16 * np.finfo(real).eps
    np.testing.assert_allclose(twice.x, frame.rotated(0.9).x, atol=atol)
    np.testing.assert_allclose(once.z, frame.z, atol=atol)
    np.testing.assert_allclose(frame.rotated(np.pi / 2).x, frame.y, atol=atol)


def test_a_brdf_does_not_know_where_its_surface_stands() -> None:
    """Rotate normal, tangent, viewer and light alike, and the value stays; rotate the tangent alone, and it does not."""
    brdf = mf.Microfacet(mf.Smith(mf.GGX(0.5, 0.1)), mf.Dielectric(1.5))
    wo, wi, tangent = hemisphere(200, 8), hemisphere(200, 9), np.array([1.0, 0, 0])
    expected = brdf.evaluate(wo, wi)
    for turn in Rotation.random(5, rng=1):
        frame = mf.Frame(turn.apply([0, 0, 1]), turn.apply(tangent))
        there = [frame.to_local(turn.apply(w)) for w in (wo, wi)]
        np.testing.assert_allclose(brdf.evaluate(*there), expected, rtol=1e-10)
        across = frame.rotated(np.pi / 2)
        swapped = mf.Microfacet(mf.Smith(mf.GGX(0.1, 0.5)), mf.Dielectric(1.5))
        np.testing.assert_allclose(swapped.evaluate(*[across.to_local(turn.apply(w)) for w in (wo, wi)]), expected, rtol=1e-10)


def test_frames_compare_and_pickle() -> None:
    frame = mf.Frame([0, 0, 2.0], [1, 1, 0])
    assert frame == mf.Frame([0, 0, 2.0], [1, 1, 0]) == pickle.loads(pickle.dumps(frame)) != frame.rotated(0.1)
    assert hash(frame) == hash(pickle.loads(pickle.dumps(frame)))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([0, 0, 0],), r"normal must not be the zero vector, got \[0. 0. 0.\]"),
        (([[0, 0, 1], [0, 0, 0]],), "normal must not be the zero vector"),
        (([0, 0, 1], [0, 0, 0]), "tangent must not be the zero vector"),
        (([0, 0, 1], [0, 0, -3]), "tangent must not be parallel to the normal, got a sine of 0"),
        (([1, 1, 1], [2, 2, 2 + 1e-15]), "tangent must not be parallel to the normal"),
        (([0, 0, 1, 0],), r"normal must have shape \(..., 3\), got shape \(4,\)"),
        (([0, 0, np.nan],), "normal must be finite"),
        ((["z"] * 3,), "normal must be an array of numbers"),
    ],
)
def test_what_makes_no_frame(arguments: tuple[object, ...], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        mf.Frame(*arguments)


def test_angles_and_directions_are_numbers() -> None:
    with pytest.raises(ValueError, match="angle must be finite"):
        mf.Frame([0, 0, 1]).rotated(np.inf)
    with pytest.raises(ValueError, match=r"w must have shape \(..., 3\)"):
        mf.Frame([0, 0, 1]).to_local([1, 0])
