"""A chapter: execute its cells, put their results into its Markdown, set that as Typst.

python workflow/chapter.py chapters/NAME.md build/chapters/NAME.md build/chapters/NAME.typ
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import fences
import inventory

DIRECTIVE = re.compile(r"^(?:```+|~~~+|:::+)\s*\{([^}#.=\s][^}]*)\}", re.M)
CELL_FENCE = re.compile(r"^(````+|~~~+)\s*\{code-cell\}", re.M)
ROLE = re.compile(r"\{[a-z][\w:-]*\}`[^`\n]+`")
LONGEST_CELL = 4


def complaints(path: Path) -> list[str]:
    """What the build would lose without a word, and what our own rules forbid, by line."""
    text = inventory.text_of(path)
    faults = [(m.start(), f"the directive {{{m[1]}}} is not {{code-cell}}") for m in DIRECTIVE.finditer(text)
             if m[1] != "code-cell"]  # fmt: skip
    faults += [(at, f"{what} is never closed") for at, what in fences.unclosed(text)]
    faults += [(m.start(), f"a cell is fenced by ```, not by {m[1]}") for m in CELL_FENCE.finditer(text)]
    faults += [(m.start(), f"the role {m[0]} would be printed as it stands") for m in ROLE.finditer(text)]
    prose = re.sub(inventory.CELL, blank, text)
    faults += [(m.start(), "an inline value with braces of its own would be printed as it stands; give it a name in a cell")
              for m in re.finditer(r"\{\{", re.sub(inventory.INLINE, blank, prose))]  # fmt: skip
    lengths = [(m.start(), len(inventory.code_of(m[1]).strip().splitlines())) for m in inventory.CELL.finditer(text)]
    faults += [(at, f"a cell of {n} lines; at most {LONGEST_CELL} are allowed") for at, n in lengths if n > LONGEST_CELL]
    return [f"{path}, line {line_at(text, place)}: {what}." for place, what in sorted(faults)]


def blank(match: re.Match[str]) -> str:
    """Spaces of the same length and lines."""
    return re.sub(r"[^\n]", " ", match[0])


def line_at(text: str, place: int) -> int:
    return text.count("\n", 0, place) + 1


# Execute ---------------------------------------------------------------------------------------


def read_notebook(path: Path) -> Any:
    """The chapter as a notebook, with one hidden cell for the inline values of each prose cell."""
    import jupytext

    notebook = jupytext.reads(inventory.body_of(inventory.text_of(path)), fmt="md:myst")
    cells = []
    for cell in notebook.cells:
        values = inventory.INLINE.findall(cell.source) if cell.cell_type == "markdown" else []
        if values:
            cells.append(value_cell(values))
        cells.append(cell)
    for number, cell in enumerate(cells):
        cell["id"] = f"cell-{number}"
    notebook.cells = cells
    return notebook


def value_cell(values: list[str]) -> Any:
    """A cell that prints the inline values as JSON; it leaves no name behind."""
    from nbformat.v4 import new_code_cell

    pairs = [inventory.split_format(value) for value in values]
    items = ", ".join(f"format({code}, {spec!r})" for code, spec in pairs)
    source = f"print(__import__('json').dumps([{items}]))"
    return new_code_cell(source, metadata={"tags": ["inline"]})


def execute(path: Path, notebook: Any) -> None:
    """Run all cells in the folder the build runs in; the first error ends with its place."""
    if all(cell.cell_type != "code" for cell in notebook.cells):
        return
    from nbclient import NotebookClient
    from nbclient.exceptions import CellExecutionError, DeadKernelError

    with tempfile.TemporaryDirectory() as scratch:
        os.environ |= {"IPYTHONDIR": scratch, "JUPYTER_PLATFORM_DIRS": "1", "PYDEVD_DISABLE_FILE_VALIDATION": "1"}
        os.environ["PYTHONPATH"] = os.pathsep.join(str(Path(folder).resolve()) for folder in ("workflow", "lib"))
        client = NotebookClient(
            notebook,
            timeout=600,
            record_timing=False,
            kernel_name="python3",
            extra_arguments=["--IPKernelApp.log_level=ERROR"],
        )
        try:
            client.execute()
        except CellExecutionError as error:
            inventory.stop(f"{place_of_error(path, notebook)}: {error.ename}: {error.evalue}")
        except DeadKernelError:
            inventory.stop(f"{place_of_error(path, notebook)}: the cell ended its Python process.")


def place_of_error(path: Path, notebook: Any) -> str:
    """File and line of the cell that failed: the last one that was begun."""
    begun = [cell for cell in notebook.cells if cell.cell_type == "code" and cell.execution_count]
    failed = begun[-1] if begun else notebook.cells[0]
    text = inventory.text_of(path)
    if "inline" in failed.metadata.get("tags", []):
        after = notebook.cells[notebook.cells.index(failed) + 1]
        values = ", ".join("{{" + value + "}}" for value in inventory.INLINE.findall(after.source))
        return f"{path}, line {line_at(text, text.find('{{'))} or later, in {values}"
    spot = max(text.find(failed.source), 0)
    return f"{path}, line {line_at(text, spot)}, in `{failed.source.strip().splitlines()[0]}`"


# Markdown --------------------------------------------------------------------------------------


def to_markdown(notebook: Any, files: Path) -> str:
    """Prose with its inline values, and what the cells show."""
    parts: list[str] = []
    values: list[str] = []
    for number, cell in enumerate(notebook.cells):
        tags = set(cell.metadata.get("tags", []))
        if cell.cell_type == "markdown":
            parts.append(fill(cell.source, values))
            values = []
        elif "inline" in tags:
            values = json.loads("".join(output.get("text", "") for output in cell.outputs))
        elif cell.cell_type == "code" and "remove-cell" not in tags:
            parts += cell_parts(cell, tags, files, number)
    return "\n\n".join(part.strip("\n") for part in parts) + "\n"


def fill(prose: str, values: list[str]) -> str:
    """The prose with each {{expression}} replaced by its value."""
    left = iter(values)
    return inventory.INLINE.sub(lambda match: next(left), prose)


def cell_parts(cell: Any, tags: set[str], files: Path, number: int) -> list[str]:
    parts = []
    if "show-input" in tags and "remove-input" not in tags:
        parts.append(f"```python\n{cell.source}\n```")
    if "remove-output" not in tags:
        for index, output in enumerate(cell.outputs):
            parts.append(output_text(output, files / f"{number}-{index}"))
    return parts


def output_text(output: Any, file: Path) -> str:
    """Markdown before pictures, pictures before TeX, TeX before plain text."""
    if output.output_type == "stream":
        return f"```\n{output.text}\n```" if output.name == "stdout" else ""
    bundle = output.get("data", {})
    if "text/markdown" in bundle:
        return str(bundle["text/markdown"])
    if "image/svg+xml" in bundle:
        inventory.write_atomically(file.with_suffix(".svg"), bundle["image/svg+xml"])
        return f"![]({file.with_suffix('.svg')})"
    if "text/latex" in bundle:
        return str(bundle["text/latex"])
    return f"```\n{bundle.get('text/plain', '')}\n```"


# Typst -----------------------------------------------------------------------------------------


def to_typst(markdown: str, source: Path) -> str:
    import pypandoc

    pandoc = pypandoc.get_pandoc_path()
    flags = ["--from=markdown-auto_identifiers", "--to=typst", "--columns=10000", "--wrap=preserve"]
    flags += ["--fail-if-warnings", "--lua-filter=workflow/filter.lua"]
    done = subprocess.run([pandoc, *flags], input=markdown, capture_output=True, text=True, check=False)
    if done.returncode:
        inventory.stop(f"{source}: {done.stderr.strip()}")
    return f'#import "/workflow/template.typ": *\n\n{done.stdout}'


def main(source: Path, markdown: Path, typst: Path) -> None:
    faults = complaints(source)
    if faults:
        inventory.stop("\n".join(faults))
    notebook = read_notebook(source)
    execute(source, notebook)
    text = to_markdown(notebook, markdown.with_suffix(""))
    inventory.write_atomically(markdown, text)
    inventory.write_atomically(typst, to_typst(text, source))


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
