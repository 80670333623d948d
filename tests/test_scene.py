"""Every statement that says something of a scene holds in it. That it would be noticed if not, tests/mutation shows."""

from __future__ import annotations

import microfacet as mf
import pytest
import scene


@pytest.mark.parametrize("key", scene.LEFT)
def test_statement_holds_in_a_scene(key: str) -> None:
    assert scene.wrong(mf.equations[key]) == ""
