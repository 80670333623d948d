r"""Where little is masked, Smith's $\Lambda$ as it is printed is noise.

Above, right decimal digits of $\Lambda$ over roughness and the angle of the view, as in the figure before, by the closed
forms and by the library, in both precisions. The line encloses what has fewer than three. All of it depends on
$a = 1/(\alpha \tan\theta_o)$ alone, and below are the digits over $a$: thick in double, thin in single precision. Walter's fit
has hardly three anywhere, in whatever precision. Where maps are hatched and curves end, $\Lambda$ is too small a number for
the precision.
"""

import sys

from maps import ANGLES, digit_map
from report import plotting

SLIDES = (58, 62, 63)
MAPS = {"ggx_root": "GGX, root", "ggx_library": "GGX, library", "beckmann_erf": "Beckmann, erf"}
MAPS["beckmann_library"] = "Beckmann, library"
CAUSES = {
    "ggx_root": ("$\\sqrt{1+s}-1$\ncancels", "w", (-3.6, -5)),
    "beckmann_erf": ("$\\mathrm{erf}-1$ cancels", "k", (-2.2, 6.5)),
}
FORMS = {"ggx": {"root": "closed form", "library": "library"}}
FORMS["beckmann"] = {"erf": "with erf", "erfc": "with erfc", "walter": "Walter's fit", "library": "library"}


def maps(axes: plotting.Array, data: dict) -> object:
    """Two rows of maps, in double precision and in single."""
    for row, real in zip(axes, ("float64", "float32"), strict=True):
        for ax, (name, title) in zip(row, MAPS.items(), strict=True):
            filled = digit_map(ax, data, f"{name}_{real}")
            ax.set(xticks=[-8, -4, 0], xticklabels=[] if real == "float64" else ["$10^{-8}$", "$10^{-4}$", "1"])
            ax.set(yticks=[-8, -4, 0, 4, 8], yticklabels=ANGLES if ax is row[0] else [])
            if real == "float64":
                ax.set_title(title)
            elif name in CAUSES:
                text, colour, place = CAUSES[name]
                plotting.label(ax, place, text, color=colour, fontsize=6.5)
        row[0].set_ylabel({"float64": "double", "float32": "single"}[real] + r": $\theta_o$")
    for ax in axes[1]:
        ax.set_xlabel(r"$\alpha$", labelpad=1)
    return filled


def curves(ax: plotting.Axes, data: dict, kind: str) -> None:
    """Digits over a, of every form."""
    styles = plotting.plt.rcParams["axes.prop_cycle"].by_key()["linestyle"]
    for k, (form, label) in enumerate(FORMS[kind].items()):
        for real, width in (("float64", 1.5), ("float32", 0.7)):
            named = label if real == "float64" else None
            digits = data[f"{kind}_{form}_{real}_curve"]
            ax.semilogx(data[f"{kind}_a"], digits, f"C{k}", linestyle=styles[k], linewidth=width, label=named)
    ax.axhline(data["few"], color="0.6", linestyle="-", linewidth=0.5)
    ax.set(ylim=(-0.3, 16.5), yticks=[0, 3, 7, 15], xlabel="$a$")
    ax.set_xticks([1e-2, 1, 1e4, 1e8] if kind == "ggx" else [0.1, 1, 10])
    ax.set_xlim(data[f"{kind}_a"][0], data[f"{kind}_a"][-1])
    ax.set_title({"ggx": "GGX", "beckmann": "Beckmann"}[kind])
    place = {"ggx": (0.62, 0.52), "beckmann": (0.0, 0.4)}[kind]
    ax.legend(loc="lower left", bbox_to_anchor=place, handlelength=1.9, fontsize=6.5, labelspacing=0.12)


def draw(data: dict) -> plotting.Figure:
    figure, axes = plotting.canvas(__file__, height=5.1, nrows=3, ncols=4)
    figure.subplots_adjust(left=0.14, right=0.9, bottom=0.06, top=0.95, wspace=0.1, hspace=0.14)
    filled = maps(axes[:2], data)
    for ax in axes[2]:
        ax.remove()
    for kind, place in (("ggx", (0.14, 0.08, 0.33, 0.183)), ("beckmann", (0.56, 0.08, 0.34, 0.183))):
        curves(figure.add_axes(place), data, kind)
    figure.axes[-2].set_ylabel("right digits")
    bar = figure.colorbar(filled, cax=figure.add_axes((0.92, 0.4, 0.018, 0.55)))
    bar.set_ticks([0, 3, 7, 15])
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
