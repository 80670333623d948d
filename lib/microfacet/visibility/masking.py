"""Masking: how much of a facet is seen, and what every masking model shares.

`Masking` is what every model of masking and shadowing shares. A model names two kernels, G1 and G2, over a distribution.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, ClassVar

import sympy as sp

from microfacet.directions import as_uniform, as_vectors
from microfacet.geometry.slopes import Distribution, normals_integral
from microfacet.kernels import Batch, Parameters
from microfacet.notation import G1, D, mu_o, om, raw
from microfacet.statement import Equation

# --- statements ---------------------------------------------------------------------------------------------------

seen = raw("A_plus", r"A^{+}", positive=True)  # projected area of all facets turned to the viewer
hidden = raw("A_minus", r"A^{-}", positive=True)  # projected area of all facets turned away

with sp.evaluate(False):
    conservation = Equation(
        key="visibility.masking.projected_area",
        title="visible facets project to the area of the surface",
        symbol=normals_integral(r"G_1(\omega_o, \omega_m) \left\langle \omega_o, \omega_m \right\rangle D(\omega_m)"),
        equals=mu_o,
        slides=(39, 40),
        cite="heitz2014",
        note="The second validation equation; each model below is put to it.",
    )
    visible_normals = Equation(
        key="visibility.masking.D_visible",
        title="the distribution of visible normals",
        symbol=raw("D_visible", r"D_{\omega_o}(\omega_m)"),
        equals=G1 * om * D / mu_o,
        over={G1: (0, 1), om: (1e-9, 1), D: (1e-6, 1e6), mu_o: (1e-8, 1)},
        slides=(41, 42, 43),
        cite="heitz2014",
    )
    visible_norm = Equation(
        key="visibility.masking.visible_norm",
        title="visible normals are a distribution",
        symbol=normals_integral(r"D_{\omega_o}(\omega_m)"),
        equals=sp.Integer(1),
        slides=(42, 43),
        cite="heitz2014",
        note="The third validation equation: the second, divided by the cosine.",
    )

# --- what every model shares ------------------------------------------------------------------------------------------


class Masking:
    """A model of masking and shadowing over a distribution of normals.

    ndf: the distribution. parameters: what the kernels take last: the distribution's parameters, then the model's own.
    """

    G1_kernel: Callable[..., float]  # G1(ox, oy, oz, mx, my, mz, parameters)
    G2_kernel: Callable[..., float]  # G2(ox, oy, oz, ix, iy, iz, mx, my, mz, parameters)
    visible_sampler: ClassVar[Callable[..., tuple[float, float, float]] | None] = None
    parameters: Parameters

    def __init__(self, ndf: Distribution) -> None:
        if not isinstance(ndf, Distribution):
            raise ValueError(f"ndf must be a distribution of normals such as GGX(0.3), got {ndf!r}")
        self.ndf = ndf
        self.parameters = (ndf.parameters, ())

    def G1(self, wo: Any, wm: Any) -> Any:
        """Share of the facets with normal wm that wo sees, in [0, 1] for a physical model; shapes (..., 3) -> (...)."""
        return over_pairs(self.G1_kernel)([as_vectors("wo", wo), as_vectors("wm", wm)], self.parameters)

    def G2(self, wo: Any, wi: Any, wm: Any) -> Any:
        """Share of the facets with normal wm that both wo and wi see; shapes (..., 3) -> (...)."""
        arrays = [as_vectors("wo", wo), as_vectors("wi", wi), as_vectors("wm", wm)]
        return over_triples(self.G2_kernel)(arrays, self.parameters)

    def D_visible(self, wo: Any, wm: Any) -> Any:
        """Distribution of the normals that wo sees, 1/sr; shapes (..., 3) -> (...). heitz2014."""
        kernel = visible_density(self.G1_kernel, type(self.ndf).kernel)
        return over_pairs(kernel)([as_vectors("wo", wo), as_vectors("wm", wm)], self.parameters)

    def sample_visible(self, wo: Any, u: Any) -> Any:
        """Normals distributed as `D_visible`, shapes (..., 3) and (..., 2) -> (..., 3); the zero vector if wo is below the
        horizon. ValueError if the model has no such sampler."""
        sampler = self.sampler
        if sampler is None:
            raise ValueError(f"{self!r} has no sampler of visible normals; Smith over GGX or Beckmann has")
        return _sampling(sampler)([as_vectors("wo", wo), as_uniform("u", u)], self.parameters)

    @property
    def sampler(self) -> Callable[..., tuple[float, float, float]] | None:
        """The kernel that samples visible normals, if there is one."""
        return type(self).visible_sampler

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.ndf!r})"


@cache
def over_pairs(kernel: Callable[..., float]) -> Batch:
    """A kernel of two directions over arrays."""
    return Batch(kernel, [3, 3])


@cache
def over_triples(kernel: Callable[..., float]) -> Batch:
    """A kernel of three directions over arrays."""
    return Batch(kernel, [3, 3, 3])


@cache
def _sampling(kernel: Callable[..., tuple[float, float, float]]) -> Batch:
    return Batch(kernel, [3, 2], 3)


stated_visible = visible_normals.scalar


@cache
def visible_density(masking: Callable[..., float], normals: Callable[..., float]) -> Callable[..., float]:
    """The kernel of D_visible for a masking function and a distribution."""

    def density(ox: float, oy: float, oz: float, mx: float, my: float, mz: float, p: Any) -> float:
        cosine = ox * mx + oy * my + oz * mz
        if not (oz > 0.0 and cosine > 0.0 and mz > 0.0):
            return 0.0
        return stated_visible(masking(ox, oy, oz, mx, my, mz, p), cosine, normals(mx, my, mz, p[0]), oz)

    return density
