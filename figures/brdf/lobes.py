r"""A BRDF may be nowhere negative, reciprocal and lossy enough, and yet belong to no surface.

Left: what five models reflect in the plane of incidence, $\rho \cos\theta_o$ in 1/sr, of light from $60^\circ$ with
$F = 1$; the dashed line is the mirror direction. Right: their albedos, by quadrature, below 1 at every angle. Below:
the verdicts. All five are nowhere negative, reciprocal, and reflect no more than they receive; those with Kelemen's
and the Implicit masking function fail the validation equations all the same, though Kelemen's lobe looks much like
Smith's. Roughness is $\alpha = 0.4$ throughout.
"""

import sys

import numpy as np
from report import plotting

SLIDES = (51, 52)
MODEL = (
    "each masking function in turn, one bounce, perfect mirrors",
    "the models are what it compares",
)
RINGS = (0.5, 1.0)


def lobes(ax: plotting.Axes, data: dict) -> None:
    """Polar curves over the plane of incidence; light comes from the left."""
    plotting.scene(ax, x=(-1.08, 1.12), z=(-0.12, 1.1))
    theta, half = np.radians(data["theta_o"]), np.linspace(-np.pi / 2, np.pi / 2, 60)
    for ring in RINGS:
        ax.plot(ring * np.sin(half), ring * np.cos(half), color="0.85", linestyle="-", linewidth=0.5, zorder=0)
        plotting.label(ax, (-ring, -0.07), f"{ring:g}", fontsize=8, color="0.4")
    ax.plot([-1.08, 1.12], [0, 0], color="0.3", linestyle="-", linewidth=0.6)
    turn = np.radians(data["degrees"])
    mirror = np.array([np.sin(turn), np.cos(turn)])
    ax.plot(*np.stack([0 * mirror, 1.1 * mirror], axis=1), color="0.5", linestyle=(0, (3, 2)), linewidth=0.6)
    plotting.arrow(ax, (-mirror[0], mirror[1]), (0, 0))
    plotting.label(ax, (-0.72, 0.52), r"$\omega_i$")
    for radius in data["lobe"]:
        ax.plot(radius * np.sin(theta), radius * np.cos(theta))


def verdicts(ax: plotting.Axes, data: dict) -> None:
    """Legend and verdicts, one line for each model."""
    plotting.scene(ax, x=(0, 6), z=(-0.1, 1.4))
    plotting.label(ax, (3.4, 1.25), "the classic three")
    plotting.label(ax, (5.0, 1.25), "validation equations")
    styles = plotting.plt.rcParams["axes.prop_cycle"].by_key()
    for k, name in enumerate(data["names"]):
        z = 1.0 - 0.24 * k
        ax.plot([0.6, 1.0], [z, z], color=styles["color"][k], linestyle=styles["linestyle"][k])
        plotting.label(ax, (1.1, z), name, ha="left")
        plotting.verdict(ax, (3.4, z), data["classic"][k] == "holds", size=0.06)
        plotting.verdict(ax, (5.0, z), data["physical"][k] == "holds", size=0.06)


def draw(data: dict) -> plotting.Figure:
    figure, axes = plotting.canvas(__file__, height=3.5)
    axes.remove()
    places = ((0, 0.46, 0.6, 0.54), (0.665, 0.57, 0.32, 0.36), (0, 0, 1, 1.5 / 3.5))
    polar, albedo, legend = (figure.add_axes(place) for place in places)
    lobes(polar, data)
    for values in data["albedo"]:
        albedo.plot(data["theta_i"], values)
    albedo.axhline(1, color="0.6", linestyle="-", linewidth=0.6, zorder=0)
    albedo.set(xlim=(0, 90), ylim=(0, 1.05), yticks=[0, 0.5, 1], xticks=[0, 30, 60, 90], xlabel=r"$\theta_i$ (degrees)")
    albedo.set_title("albedo")
    verdicts(legend, data)
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
