r"""A rough surface has more area than the plane it covers, though it projects to no more.

Left: the area $\int D(\omega_m)\, d\omega_m$ of the microsurface for each unit of area of the plane; lines are the
closed forms, dots the same integral by quadrature over slopes, crosses the facets of Gaussian surfaces added up (two
standard errors over eight surfaces are smaller than a cross). GGX at $\alpha = 1$ has exactly twice the area of its
plane. Right: where this area comes from at $\alpha = 0.5$, as area per degree of the angle of the normal; what lies
under each curve is the value at $\alpha = 0.5$ on the left. GGX has facets of every steepness, and more area in its
tail than Beckmann.
"""

import sys

from report import plotting

SLIDES = (34,)


def draw(data: dict) -> plotting.Figure:
    figure, (area, density) = plotting.canvas(__file__, height=2.2, ncols=2)
    figure.subplots_adjust(left=0.06, right=0.985, bottom=0.2, top=0.89, wspace=0.2)
    for k, (name, title) in enumerate((("ggx", "GGX"), ("beckmann", "Beckmann"))):
        (line,) = area.plot(data["alpha"], data[name], label=title)
        area.plot(data["checked"], data[f"{name}_checked"], "os"[k], color=line.get_color(), markersize=3.5)
        density.plot(data["theta"], data[f"{name}_density"])
    look = {"color": plotting.COLOURS["ink"], "markersize": 5, "markeredgewidth": 1, "linestyle": "none", "zorder": 4}
    area.plot(data["made"], data["made_area"], "x", label="Gaussian surfaces", **look)
    area.axhline(1, color="0.6", linestyle="-", linewidth=0.6, zorder=0)
    plotting.label(area, (0.97, 0.985), "the plane", color="0.4", ha="right", va="top", fontsize=8)
    area.set(xlim=(0, 1.02), ylim=(0.9, 2.05), xticks=[0, 0.2, 0.4, 0.6, 0.8, 1], xlabel=r"$\alpha$")
    area.set_title(r"area of the microsurface (m$^2$/m$^2$)")
    density.set(xlim=(0, 90), ylim=(0, None), xticks=[0, 30, 60, 90], xlabel=r"$\theta_m$ (degrees)")
    density.set_title(r"area at $\alpha = 0.5$ (m$^2$/m$^2$ per degree)")
    area.legend(loc="upper left")
    return figure


if __name__ == "__main__":
    data, *outputs = sys.argv[1:]
    plotting.save(draw(plotting.load(data)), outputs)
