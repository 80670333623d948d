"""Computes what the figure `spheres` shows: spheres shaded by the library's BRDFs under an environment of soft lights."""

import sys

import microfacet as mf
import numpy as np
from report.datafile import store

SIZE, EXPOSURE = 140, 1.1
ROUGHNESS = ((0.08, 0.08), (0.25, 0.25), (0.6, 0.6), (0.08, 0.5))
SAMPLES = (768, 768, 768, 3072)  # in a pixel, for each roughness: more where highlights are drawn out
METAL = mf.Conductor(0.2, 3.9)  # close to silver in green light
SKY, GROUND = np.array([0.50, 0.62, 0.78]), np.array([0.14, 0.115, 0.10])
LIGHTS = (  # direction, how narrow, radiance
    ((-0.62, 0.62, 0.48), 60.0, (13.0, 11.6, 9.8)),
    ((0.85, 0.30, 0.30), 30.0, (2.4, 3.4, 5.0)),
    ((0.25, 0.90, 0.35), 500.0, (40.0, 40.0, 38.0)),
)
STEP = np.array([0.7548776662466927, 0.5698402909980532])  # 1/g, 1/g^2 with g^3 = g + 1: steps that fill a square evenly


def environment(w: np.ndarray) -> np.ndarray:
    """Radiance from the directions w (..., 3), y up, as red, green and blue: a horizon and three round lights."""
    above = 1 / (1 + np.exp(-25 * w[..., 1:2]))
    light = above * SKY * (0.7 + 0.5 * w[..., 1:2]) + (1 - above) * GROUND
    for towards, narrow, radiance in LIGHTS:
        cosine = w @ (np.array(towards) / np.linalg.norm(towards))
        light = light + np.exp(narrow * (cosine - 1))[..., None] * np.array(radiance)
    return light


def disc() -> tuple[np.ndarray, np.ndarray]:
    """Normals of a sphere seen from +z, one for each of its pixels, and how much of each pixel it covers."""
    side = (np.arange(SIZE) + 0.5) / SIZE * 2.02 - 1.01
    x, y = np.meshgrid(side, -side)
    radius = np.hypot(x, y)
    inside = np.minimum(radius, 0.999) / np.maximum(radius, 1e-9)
    x, y = x * np.where(radius > 0.999, inside, 1), y * np.where(radius > 0.999, inside, 1)
    cover = np.clip((1 - radius) * SIZE / 2.02 + 0.5, 0, 1)
    return np.stack([x, y, np.sqrt(1 - x**2 - y**2)], axis=-1)[cover > 0], cover


def frames(normal: np.ndarray) -> np.ndarray:
    """Local axes (n, 3 axes, 3): along the circles of latitude, along the meridians, and the normal."""
    along = np.cross([0.0, 1.0, 0.0], normal)
    along /= np.linalg.norm(along, axis=-1, keepdims=True)
    return np.stack([along, np.cross(normal, along), normal], axis=1)


def light_directions(u: np.ndarray) -> np.ndarray:
    """Directions (n, 3) towards the lights, each light as often, spread as its radiance; u (n, 2) in [0, 1)."""
    pick, rest = np.divmod(u[:, 0] * len(LIGHTS), 1.0)
    towards, narrow = (np.array([light[k] for light in LIGHTS]) for k in (0, 1))
    towards = towards / np.linalg.norm(towards, axis=-1, keepdims=True)
    axes, narrow = frames(towards)[pick.astype(int)], narrow[pick.astype(int)]
    cosine, turn = 1 + np.log1p(-rest * (1 - np.exp(-2 * narrow))) / narrow, 2 * np.pi * u[:, 1]
    sine = np.sqrt(np.maximum(0, 1 - cosine**2))
    return np.einsum("nij,ni->nj", axes, np.stack([sine * np.cos(turn), sine * np.sin(turn), cosine], axis=-1))


def light_density(w: np.ndarray) -> np.ndarray:
    """Density of `light_directions`, 1/sr."""
    parts = [
        narrow / (2 * np.pi * (1 - np.exp(-2 * narrow))) * np.exp(narrow * (w @ (np.array(d) / np.linalg.norm(d)) - 1))
        for d, narrow, _ in LIGHTS
    ]
    return np.mean(parts, axis=0)


def shade(brdf: mf.BRDF, guide: mf.Microfacet, axes: np.ndarray, shift: np.ndarray, samples: int) -> np.ndarray:
    """Radiance that leaves towards +z, shape (2, n, 3), from each half of the samples.

    Directions come from the visible normals of `guide` and from the lights by turns; each counts by the mean of both
    densities.
    """
    wo, total = np.ascontiguousarray(axes[:, :, 2]), np.zeros((2, len(axes), 3))
    for k in range(samples):
        u = (shift + (k // 2 + 1) * STEP) % 1.0
        wi = guide.sample(wo, u) if k % 2 else np.einsum("nij,nj->ni", axes, light_directions(u))
        world = np.einsum("nij,ni->nj", axes, wi)
        density = (guide.pdf(wo, wi) + light_density(world)) / 2
        weight = brdf.evaluate(wo, wi) * wi[:, 2] / density
        total[2 * k // samples] += weight[:, None] * environment(world)
    return total / (samples / 2)


def picture(light: np.ndarray, cover: np.ndarray) -> np.ndarray:
    """Exposed, in the curve of sRGB, and transparent outside the sphere: bytes (size, size, 4)."""
    shown = 1 - np.exp(-EXPOSURE * light)
    curved = np.where(shown <= 0.0031308, 12.92 * shown, 1.055 * shown ** (1 / 2.4) - 0.055)
    image = np.zeros((SIZE, SIZE, 4))
    image[cover > 0, :3] = curved
    image[..., 3] = cover
    return np.round(255 * image).astype(np.uint8)


def compute() -> dict:
    normal, cover = disc()
    axes, shift = frames(normal), np.random.default_rng(0).random((len(normal), 2))
    images, noise = [], []
    for ndf in (mf.GGX, mf.Beckmann):
        for alphas, samples in zip(ROUGHNESS, SAMPLES, strict=True):
            once, guide = (mf.Microfacet(mf.Smith(one(*alphas)), METAL) for one in (ndf, mf.GGX))
            first, second = shade(mf.Compensated(once, "lobe"), guide, axes, shift, samples)
            images.append(picture((first + second) / 2, cover))
            noise.append(np.sqrt(np.mean((first - second) ** 2)) / np.mean(first + second))
    shape = (2, len(ROUGHNESS))
    return {
        "images": np.array(images).reshape(*shape, SIZE, SIZE, 4),
        "alphas": np.array(ROUGHNESS),
        "noise": np.round(np.reshape(noise, shape), 4),
        "samples": np.array(SAMPLES),
    }


if __name__ == "__main__":
    store(sys.argv[1], **compute())
