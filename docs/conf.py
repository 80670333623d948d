"""How `make docs` builds the site: Sphinx over the docstrings and the pages of this folder, without the network."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "lib"), str(ROOT / "docs/extensions")]

import microfacet  # noqa: E402

project = "microfacet"
author = "The microfacet authors"
copyright = author  # noqa: A001
version = release = microfacet.__version__

extensions = ["sphinx.ext.autodoc", "sphinx.ext.autosummary", "numpydoc", "myst_parser", "sphinxcontrib.bibtex", "mathml"]
exclude_patterns = ["templates", "extensions"]
templates_path = ["templates"]
nitpicky = True
default_role = "any"
suppress_warnings = ["bibtex.missing_field"]  # reports without an institution

autodoc_typehints = "none"  # numpydoc's sections have them, with shapes
autodoc_member_order = "bysource"
autosummary_generate = True
numpydoc_show_class_members = False  # autodoc shows them, with their docstrings
myst_enable_extensions = ["dollarmath", "deflist"]
myst_heading_anchors = 3
html_math_renderer = "mathml"
bibtex_bibfiles = ["../chapters/references.bib"]
bibtex_reference_style = "author_year"

html_theme = "furo"
html_title = f"microfacet {release}"
html_show_sourcelink = False
html_copy_source = False
html_show_sphinx = False
html_last_updated_fmt = None
html_static_path = ["static"]
html_css_files = ["site.css"]
html_theme_options = {"navigation_with_keys": True}

# The keys of the bibliography, which docstrings name as they are, become citations.
KEYS = re.findall(r"^@\w+\{(\w+),", (ROOT / "chapters/references.bib").read_text("utf-8"), re.M)
CITED = re.compile(rf"(?<![\w`])({'|'.join(KEYS)})(?!\w)")


def cite(app: Any, what: str, name: str, thing: Any, options: Any, lines: list[str]) -> None:
    lines[:] = [CITED.sub(r":cite:t:`\1`", line) for line in lines]


def name_base(app: Any, what: str, name: str, thing: Any, options: Any, lines: list[str]) -> None:
    """Below a class's summary the nearest class above it that has a page."""
    public = (getattr(microfacet, name) for name in microfacet.PUBLIC)
    pages = {one: one.__name__ for one in public if isinstance(one, type)}
    above = [pages[base] for base in thing.__mro__[1:] if base in pages] if isinstance(thing, type) else []
    if above:
        summary = next(k for k, line in enumerate(lines) if line.strip())
        lines[summary + 1 : summary + 1] = ["", f"A subclass of :py:class:`{above[0]}`."]


INNER = {"evaluation", "panels", "reflected", "sampler", "shown", "smith_lobe"}  # what quadratures and loops ask of a model


def skip_inner(app: Any, what: str, name: str, thing: Any, skip: bool, options: Any) -> bool | None:
    return True if name in INNER or name.endswith(("_kernel", "_of_facet")) else None


def setup(app: Any) -> None:
    app.connect("autodoc-process-docstring", cite, priority=900)  # after numpydoc
    app.connect("autodoc-process-docstring", name_base, priority=901)
    app.connect("autodoc-skip-member", skip_inner)
