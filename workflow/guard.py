"""The guard at the start of a build: one build at a time, and nothing in build/ but the output of its jobs."""

from __future__ import annotations

import base64
import fcntl
import json
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import campaign
import inventory
import seal

LOCK = Path(".snakemake/turn")
UNFINISHED = Path(".snakemake/incomplete")
REPORTS = (Path("build/report.pdf"), Path("build/report.html"))
INSPECTING = (
    *("dryrun", "lint", "report", "list_rules", "list_target_rules", "summary", "detailed_summary", "dag", "rulegraph"),
    *("filegraph", "d3dag", "unlock", "touch", "archive", "containerize", "delete_all_output", "delete_temp_output"),
    *("cleanup_metadata", "cleanup_shadow", "generate_unit_tests", "list_changes", "list_input_changes"),
    *("list_params_changes", "list_untracked", "print_compilation", "list_conda_envs", "conda_cleanup_envs"),
    *("conda_create_envs_only", "container_cleanup_images"),
)
MOST_NAMED = 8
held: list[Any] = []


def builds(arguments: Sequence[str]) -> bool:
    """Whether a snakemake command line makes files, rather than lists what it would make."""
    options = [word for word in arguments if word.startswith("-")]
    if not options or {"-n", "--dry-run", "--dryrun", "--lint"} & set(options):
        return not options
    from snakemake.cli import get_argument_parser  # half a second

    asked = get_argument_parser().parse_known_args(list(arguments))[0]
    return not any(getattr(asked, name, None) for name in INSPECTING)


def begin(arguments: Sequence[str]) -> bool:
    """Refuse to run beside another build; from here on a fault in the sources deletes the old report.

    True if files are to be made.
    """
    building = builds(arguments)
    if "--lint" not in arguments:
        take_lock()
    inventory.withdrawn.extend(REPORTS if building else ())
    refuse_broken_package()
    return building


def take_lock() -> None:
    """One build at a time in one checkout; the system frees the lock when a build is killed."""
    LOCK.parent.mkdir(exist_ok=True)
    handle = LOCK.open("w")
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        inventory.stop("Another build is running in this checkout: wait for it to end.")
    held.append(handle)


def refuse_broken_package() -> None:
    """Stop if the library cannot be imported: the build writes its files with it."""
    try:
        import microfacet.files  # noqa: F401
    except Exception as error:
        inventory.fault(f"The library in lib/ cannot be imported: {inventory.said(error)}")


def compare(products: Iterable[str], building: bool) -> None:
    """Name files that are torn, altered or unfinished, so that snakemake makes them again; such a report is deleted at once."""
    paths = sorted({*map(Path, products), *seal.sealed()})
    refuse_what_is_no_file(paths)
    torn = [path for path in seal.broken(paths) if not measured(path, building)]
    if not torn:
        return
    names = ", ".join(map(str, torn[:MOST_NAMED])) + (f" and {len(torn) - MOST_NAMED} more" if len(torn) > MOST_NAMED else "")
    are = "is not what its job made" if len(torn) == 1 else "are not what their jobs made"
    print(f"{names}: {are} (torn, altered or unfinished), to be made again.", file=sys.stderr)
    for path in torn:
        mark_unfinished(path)
        if building and path in REPORTS:
            path.unlink()


def mark_unfinished(path: Path) -> None:
    """Mark a file as snakemake marks the output of a killed job: it is then made again even if no other job needs it."""
    name = base64.urlsafe_b64encode(str(path).encode()).decode()
    inventory.write_atomically(UNFINISHED / name, json.dumps({"external_jobid": None}))


def refuse_what_is_no_file(paths: Iterable[Path]) -> None:
    from microfacet.files import writable

    for path in paths:
        try:
            writable(path)
        except ValueError as fault:
            inventory.stop(f"{fault}. Move it away.")


def measured(path: Path, building: bool) -> bool:
    """Whether a range of surfaces without a seal is whole by the digest inside it; it may have taken hours."""
    if path.parent.parent != Path(campaign.FOLDER) or seal.read(path) is not None:
        return False
    from report.datafile import intact

    good = intact(path)
    if good and building:
        seal.put([path])
    return good
