"""A pytest plugin that runs test files in the order in which they are given."""

from __future__ import annotations

import pytest


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    order = {name: k for k, name in enumerate(config.args)}
    items.sort(key=lambda item: order.get(item.nodeid.split("::")[0], len(order)))
