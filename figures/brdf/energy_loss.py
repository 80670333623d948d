r"""A surface of perfect mirrors returns all light, but its model of one reflection does not.

The share of light that is lost because it meets the surface a second time, for Smith's masking and shadowing with
$F = 1$. Left: over the roughness $\alpha$, for light from straight above, from $60^\circ$, and from everywhere alike.
Right: over the angle of the light, for GGX. Dots: the closed forms at $\alpha = 1$; lines: quadrature; crosses: what
Gaussian surfaces, whose slopes are Beckmann's, were found to lose, with bars of two standard errors. Nothing is lost
at grazing angles, from which only the tops of the relief are lit. Up to where that is felt, slanting light loses more
than upright light on a smooth surface, and less on a rough one.
"""

import sys

from report import plotting

SLIDES = (73, 74, 75)
MODEL = (
    "Smith's model, one bounce, perfect mirrors",
    "it shows what one bounce leaves out",
)
LOOKS = (("ggx", "GGX", "-"), ("beckmann", "Beckmann", "--"))
VIEWS = (("view", "straight above"), ("light", r"$60^\circ$"), ("ink", "everywhere"))

CLOSED = (r"$\ln\,2$", r"$\ln(3)/2$", r"$(4\,\ln\,2 - 1)/3$")


def over_alpha(ax: plotting.Axes, data: dict) -> None:
    for name, words, style in LOOKS:
        curves = [*data[f"{name}_views"], data[f"{name}_average"]]
        for curve, (colour, view) in zip(curves, VIEWS, strict=True):
            told = f"from {view}" if style == "-" else None
            ax.plot(data["alpha"], 100 * curve, color=plotting.COLOURS[colour], linestyle=style, label=told)
        ax.plot([], [], color=plotting.COLOURS["grey"], linestyle=style, label=words)
    for value, (colour, _), closed in zip([*data["exact_views"], data["exact_average"]], VIEWS, CLOSED, strict=True):
        ax.plot(1, 100 * value, "o", color=plotting.COLOURS[colour], markersize=3.5, clip_on=False)
        plotting.label(ax, (1.025, 100 * value), closed, ha="left", fontsize=8, color=plotting.COLOURS[colour])
    for k, (colour, _) in enumerate(VIEWS[:2]):
        look = {"fmt": "x", "color": plotting.COLOURS[colour], "markersize": 4, "linewidth": 0.8, "clip_on": False}
        ax.errorbar(data["traced_alpha"], 100 * data["traced"][:, 0, k], 200 * data["traced"][:, 1, k], **look)
    ax.set(xlim=(0, 1), ylim=(0, 75), xlabel=r"roughness $\alpha$", ylabel="light lost (%)")
    ax.legend(loc="upper left")


def over_angle(ax: plotting.Axes, data: dict) -> None:
    for alpha, curve in zip(data["shown"], data["ggx_angles"], strict=True):
        ax.plot(data["theta"], 100 * curve, color=plotting.COLOURS["view"], linestyle="-")
        plotting.label(ax, (2, 100 * curve[0] + 2.5), rf"$\alpha = {alpha:g}$", ha="left")
    ax.plot(data["theta"][::3], 100 * data["exact"][::3], "o", color=plotting.COLOURS["view"], markersize=3)
    ax.set(xlim=(0, 90), ylim=(0, 75), xticks=[0, 30, 60, 90], xlabel=r"angle of the light $\theta_i$ (degrees)")


def draw(data: dict) -> plotting.Figure:
    figure, axes = plotting.canvas(__file__, height=2.7, ncols=2, sharey=True)
    figure.subplots_adjust(left=0.075, right=0.975, bottom=0.17, top=0.96, wspace=0.42)
    over_alpha(axes[0], data)
    over_angle(axes[1], data)
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
