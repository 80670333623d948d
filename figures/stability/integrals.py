r"""Integrals that miss, a density that does not sum to 1, and a test that cannot see it.

Left, errors of the projected area, which is 1, over roughness: 1024 midpoints over the polar angle; an adaptive rule, which
reports that it has converged; GGX up to the slope 10; and the library's rule, in slopes. Middle, the sum of the density of
visible normals if Walter's fit stands beside an exact sampler, for Beckmann at $\alpha = 0.3$. Right, how often a chi-square
test over 800 cells at the level 1 % rejects, at $\alpha = 0.05$ and 85 degrees: a density off by as much as the middle one; a
right one whose cells were integrated by too few nodes; and a right one. Lines are computed, dots are tests made.
"""

import sys

from report import plotting

SLIDES = (35, 36, 42, 43)
RULES = {
    "midpoint_beckmann": "midpoints, Beckmann",
    "midpoint_ggx": "midpoints, GGX",
    "adaptive": "adaptive, Beckmann",
    "truncated": "up to slope 10, GGX",
    "library_ggx": "library, both",
}
TESTS = {"walter": "{:.1f} % off", "coarse": "coarse cells", "right": "right"}


def draw(data: dict) -> plotting.Figure:
    figure, (rules, density, test) = plotting.canvas(__file__, height=2.7, ncols=3)
    figure.subplots_adjust(left=0.08, right=0.985, bottom=0.38, top=0.92, wspace=0.42)
    for name, label in RULES.items():
        rules.loglog(data["alpha"], data[name], label=label)
    rules.loglog(data["alpha"], data["library_beckmann"], "C4", linestyle="-", linewidth=0.7)
    rules.set(xlabel=r"$\alpha$", ylim=(1e-16, 10), yticks=[1e-15, 1e-10, 1e-5, 1], xticks=[1e-4, 1e-2, 1])
    rules.set_title("error of the area")
    density.plot(data["theta"], data["density_sum"], color=plotting.COLOURS["lost"])
    density.axhline(1, color="0.6", linestyle="-", linewidth=0.6)
    density.set(xlabel=r"$\theta_o$ (degrees)", xlim=(0, 90), xticks=[0, 30, 60, 90])
    density.set_title("sum of the density")
    for k, (name, label) in enumerate(TESTS.items()):
        test.semilogx(data["samples"], data[f"power_{name}"], f"C{k}", label=label.format(100 * data["off"]))
        test.plot(data["samples"][::5], data[f"made_{name}"], f"C{k}o", markersize=3)
    test.set(xlabel="samples", ylim=(-0.03, 1.03), xlim=(7e3, 1.4e8), yticks=[0, 0.5, 1], xticks=[1e4, 1e6, 1e8])
    test.set_title("rejected")
    rules.legend(loc="upper left", bbox_to_anchor=(-0.22, -0.3), ncols=2, fontsize=7, columnspacing=1)
    test.legend(loc="upper right", bbox_to_anchor=(1.05, -0.3), fontsize=7)
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
