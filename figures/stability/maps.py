"""Maps of right digits, which several figures draw."""

import numpy as np
from report import plotting

ANGLES = ["$10^{-8}$", "$10^{-4}$", r"$\pi/4$", r"$\pi/2 - 10^{-4}$", r"$\pi/2 - 10^{-8}$"]
"""Names of the polar angles whose tangents are 1e-8, 1e-4, 1, 1e4, 1e8."""


def digit_map(ax: plotting.Axes, data: dict, name: str, along: str = "alpha") -> object:
    """Digits over what is named `along` and the angle; what has failed is outlined, what no float can hold is hatched."""
    x, y, digits = np.log10(data[along]), np.log10(data["tangent"]), data[name].T
    ax.set_facecolor("0.93")
    filled = ax.contourf(x, y, digits, np.arange(0, 16.1, 1))
    ax.contourf(x, y, np.isnan(digits).astype(float), [0.5, 1.5], colors="none", hatches=["////"])
    if np.nanmin(digits) < data["few"]:
        ax.contour(x, y, digits, [data["few"]], colors=plotting.COLOURS["light"], linestyles="-", linewidths=1.2)
    return filled
