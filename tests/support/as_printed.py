"""Code of a page, run from top to bottom: it must print what the page prints."""

from __future__ import annotations

import doctest

from microfacet.model import labelled
from microfacet.statements.registry import registry


def run_as_printed(text: str, name: str) -> None:
    """Families and statements that are made are forgotten afterwards: other tests go through all there are."""
    test = doctest.DocTestParser().get_doctest(text, {"__name__": "__main__"}, name, name, 0)
    assert test.examples
    known = dict(labelled)
    try:
        with registry.without():
            assert doctest.DocTestRunner().run(test).failed == 0
    finally:
        labelled.clear()
        labelled.update(known)
