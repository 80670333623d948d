"""The campaign's jobs: measure a range of surfaces, and gather ranges.

    python workflow/campaign.py measure lobes_07 8 12 build/campaign/lobes_07/8-12.npz
    python workflow/campaign.py gather build/campaign/lobes_07.npz build/campaign/lobes_07/*.npz

Surface k and its rays depend on k only, so that any division into ranges gives the same numbers; a file is written whole
or not at all, so that a killed build loses the ranges it was at.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Callable
from pathlib import Path

FOLDER = "build/campaign"
SURFACES, RANGE = 32, 16


def ranges(count: int, size: int) -> list[tuple[int, int]]:
    """The surfaces 0..count-1 in ranges of `size`, the last one maybe shorter."""
    return [(first, min(first + size, count)) for first in range(0, count, size)]


def shards(entry: str, count: int, size: int) -> list[str]:
    return [f"{FOLDER}/{entry}/{first}-{last}.npz" for first, last in ranges(count, size)]


def entries(script: Path | None) -> list[str]:
    """What a figure's data script reads of the campaign: its constant ENTRIES, a tuple of names."""
    if script is None:
        return []
    for node in ast.parse(script.read_text("utf-8")).body:
        if isinstance(node, ast.Assign) and any(isinstance(t, ast.Name) and t.id == "ENTRIES" for t in node.targets):
            return list(ast.literal_eval(node.value))
    return []


def gathered(script: Path | None) -> list[str]:
    return [f"{FOLDER}/{entry}.npz" for entry in entries(script)]


def measure(entry: str, first: str, last: str, output: str) -> None:
    from microfacet.surface.measure import shard
    from report.campaign import CAMPAIGN
    from report.datafile import refuse, store

    if entry not in CAMPAIGN:
        sys.exit(f"The campaign has no {entry!r}; it has {', '.join(CAMPAIGN)}.")
    refuse(output)
    store(output, **shard(CAMPAIGN[entry].family, CAMPAIGN[entry].plan, int(first), int(last)))


def gather(output: str, *parts: str) -> None:
    from microfacet.surface import measure
    from report.datafile import load, store

    store(output, **measure.gather(load(part, made_in=str(Path(part).parent)) for part in parts))


if __name__ == "__main__":
    jobs: dict[str, Callable[..., None]] = {"measure": measure, "gather": gather}
    jobs[sys.argv[1]](*sys.argv[2:])
