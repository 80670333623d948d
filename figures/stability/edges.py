r"""At the edges: directions at the horizon, vectors that are not of unit length, rays that start on a facet.

Left, right digits of the BRDF of GGX, $\alpha = 0.3$, in single precision, where light and viewer mirror each other, over
their common cosine: with a floor in the denominator, with squares of squared lengths, and by the library. Middle, the relative
error of $D$ at the slope $\alpha$ if the normal is $10^{-6}$ too long, from the cosine and from all components. Right, the
share of rays that start on a relief and are wrongly found blocked or free in single precision, over the offset that is to keep
a ray from its own facet, in cells of the relief, which stands at the origin, or a thousand or a million cells away. The
library's walk has no offset.
"""

import sys

from report import plotting

SLIDES = (30, 51, 67)
MODEL = (
    "Smith's model, one bounce, perfect mirrors",
    "it shows digits, and the walk would lose the same ones at its first bounce",
)
FORMS = {"floor": "floor", "squares": "squares first", "library": "library"}


def draw(data: dict) -> plotting.Figure:
    figure, (grazing, longer, rays) = plotting.canvas(__file__, height=2.6, ncols=3)
    figure.subplots_adjust(left=0.065, right=0.985, bottom=0.36, top=0.91, wspace=0.36)
    for name, label in FORMS.items():
        grazing.semilogx(data["cosines"], data[name], label=label)
    grazing.set(xlabel="both cosines", ylim=(-0.2, 8), xticks=[1e-18, 1e-9, 1])
    grazing.set_title("right digits")
    for name, label in {"cosine": "cosine", "components": "components"}.items():
        longer.loglog(data["alpha"], data[name], label=label)
    longer.set(xlabel=r"$\alpha$", ylim=(1e-7, 1e2), yticks=[1e-6, 1e-3, 1], xticks=[1e-4, 1e-2, 1])
    longer.set_title("error of $D$")
    for wrong, shift in zip(data["rays_wrong"], data["shifts"], strict=True):
        rays.semilogx(data["offsets"], 100 * wrong, label=f"offset, {shift:,.0f} away")
    rays.axhline(100 * data["rays_library"], color="C3", linestyle=":", label="library")
    rays.set(xlabel="offset", xticks=[1e-8, 1e-4, 1], xlim=(4e-9, 2e1), ylim=(-1, None))
    rays.set_title("wrong rays (%)")
    for ax in (grazing, longer, rays):
        ax.legend(loc="upper center", bbox_to_anchor=(0.45, -0.27), fontsize=7, labelspacing=0.2)
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
