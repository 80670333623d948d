"""The talk's 75 slides: what each is about, in our words, and whether it has something to draw.

heitz2014talk. Slides that say one thing are one entry. `drawn` is False for text, photographs by others and titles;
those are told of in the prose where they matter.
"""

from __future__ import annotations

from typing import NamedTuple


class Slides(NamedTuple):
    first: int
    last: int
    about: str
    drawn: bool


SLIDES = (
    Slides(1, 2, "title and occasion", False),
    Slides(3, 3, "shading in games and films", True),
    Slides(4, 5, "fabrication and inverse design: photographs of others' results", False),
    Slides(6, 12, "all of scattering, the theory of a part of it, models outside the theory, and the way on", True),
    Slides(13, 14, "the two papers behind the talk", False),
    Slides(15, 15, "sampling normals against sampling visible normals in equal time", True),
    Slides(16, 16, "title of the first part", False),
    Slides(17, 29, "from geometry over visibility and material to the BRDF, and what is validated on the way", True),
    Slides(30, 32, "the geometric surface and the microsurface", True),
    Slides(33, 33, "facets sorted by their normals", True),
    Slides(34, 34, "the area of the microsurface", True),
    Slides(35, 36, "first equation: projected onto the plane", True),
    Slides(37, 39, "projected onto the view: flat, rough, and magnified", True),
    Slides(40, 40, "second equation: visible projected area", True),
    Slides(41, 43, "third equation: visible normals", True),
    Slides(44, 46, "fourth equation: reflected directions", True),
    Slides(47, 48, "Fresnel", True),
    Slides(49, 50, "shadowing", True),
    Slides(51, 52, "the whole BRDF and the three classic tests, which are too weak", True),
    Slides(53, 55, "first table: distributions of normals", True),
    Slides(56, 58, "second table: masking functions", True),
    Slides(59, 59, "a random surface is traced and compared", True),
    Slides(60, 60, "measured lobes beside those of V-cavities and Smith", True),
    Slides(61, 63, "isotropic models in use, and the question of anisotropy", False),
    Slides(64, 66, "roughness is a stretching in slope space", True),
    Slides(67, 67, "anisotropic distributions", True),
    Slides(68, 68, "stretching keeps masking", True),
    Slides(69, 69, "stretching keeps the visible normals", True),
    Slides(70, 71, "the roughness along the view", True),
    Slides(72, 72, "all equations hold for stretched surfaces", True),
    Slides(73, 75, "what the simplest model leaves out", True),
)
AWAITED: dict[int, str] = {}
"""Slides with something to draw that are not drawn yet, and what they wait for. A drawn slide may not stand here."""
MOVING = (33, 68)
