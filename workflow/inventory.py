"""What there is in this checkout: statements, figures, chapters. Nothing is listed by hand."""

from __future__ import annotations

import ast
import difflib
import hashlib
import os
import re
import sys
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any, NoReturn

import closure

CACHE = Path("build/inventory.json")
CELL = re.compile(r"^```\{code-cell\}[^\n]*\n(.*?)^```\s*$", re.M | re.S)
OPTIONS = re.compile(r"\A(?:---\n.*?^---\n|(?::[\w-]+:[^\n]*\n)+)", re.M | re.S)
FRONT = re.compile(r"\A---\n.*?^---\n", re.M | re.S)
INLINE = re.compile(r"\{\{([^{}]+)\}\}")


withdrawn: list[Path] = []  # the reports that a fault of the sources takes away; none unless a build has begun


def stop(sentence: str) -> NoReturn:
    """End with one sentence for the reader in place of a traceback."""
    sys.exit(f"\n{sentence}\n")


def fault(sentence: str) -> NoReturn:
    """End because the sources are at fault: an old report must not pass for one that is made of them."""
    withdraw()
    stop(sentence)


def withdraw() -> None:
    for report in withdrawn:
        report.unlink(missing_ok=True)


def source(name: str) -> str:
    """A file that people write: where it is gone, what was made of it does not stand in for it."""
    if not Path(name).is_file():
        fault(f"{name} is missing: `git checkout {name}` brings it back.")
    return name


def text_of(path: Path) -> str:
    """The text of such a file."""
    try:
        return Path(source(str(path))).read_text("utf-8")
    except ValueError as error:
        fault(f"{path} is no text in UTF-8: {error}.")


def said(error: Exception) -> str:
    """What an error says, with the file and line of a source that is no Python."""
    if isinstance(error, SyntaxError) and error.filename:
        file = os.path.relpath(error.filename)
        return f"{file}, line {error.lineno}: {error.msg}"
    return f"{type(error).__name__}: {error}"


def unknown(kind: str, name: str, known: Iterable[str]) -> str:
    """The sentence about a name that does not exist, with the nearest ones that do."""
    known = sorted(known)
    near = difflib.get_close_matches(name, known, n=3, cutoff=0.6)
    hint = f" Did you mean {' or '.join(near)}?" if near else ""
    return f"There is no {kind} called {name!r}.{hint}"


def write_atomically(path: Path, content: bytes | str) -> None:
    """A reader, or a killed build, never sees half a file."""
    from microfacet.files import write

    try:
        write(path, content)
    except (OSError, ValueError) as error:
        stop(str(error))


# Statements ------------------------------------------------------------------------------------


@cache
def statements() -> dict[str, dict[str, Any]]:
    """Every statement of the library: fingerprint, title, slides, citation and LaTeX by key.

    Importing sympy and all statements takes over a second, so the answer is cached with a digest
    of the library's sources and computed again only when one of them changed.
    """
    from microfacet.files import keep, recall

    source = digest_of_library()
    cached = recall(CACHE)
    if cached is None or cached["source"] != source:
        cached = {"source": source, "statements": ask_library()}
        with suppress(OSError, ValueError):  # then it is asked again
            keep(CACHE, cached)
    return dict(cached["statements"])


def stage(key: str) -> str:
    """The stage, whose statements are checked together: the first word of a key."""
    return key.partition(".")[0]


def digest_of_library() -> str:
    digest = hashlib.sha256(sys.version.encode())
    for path in [*sorted(closure.whole_package()), Path(source("requirements.lock"))]:
        digest.update(str(path).encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()


def ask_library() -> dict[str, dict[str, Any]]:
    try:
        import microfacet as mf
        from microfacet.statements.fingerprints import fingerprints

        for path in sorted(closure.whole_package()):
            closure.tree_of(path)
        prints = fingerprints()
        return {key: facts(mf.equations[key], prints[key]) for key in mf.equations}
    except Exception as error:
        fault(f"The library in lib/ cannot state its equations: {said(error)}")


def facts(equation: Any, fingerprint: str) -> dict[str, Any]:
    return {
        "fingerprint": fingerprint,
        "title": equation.title,
        "slides": list(equation.slides),
        "cite": equation.cite,
        "latex": equation.latex,
        "computed_latex": equation.computed_latex,
    }


# Figures ---------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Figure:
    """A script that draws: its docstring is the caption, SLIDES the slides it redraws.

    MODEL, if there is light in it: which model of light, and why that was enough.
    """

    name: str
    script: Path
    title: str
    caption: str
    slides: tuple[int, ...]
    moves: bool = False
    model: tuple[str, ...] = ()

    @property
    def moving(self) -> str:
        """The drawing that moves, for the web page, if the script has a function `move`."""
        return f"build/figures/{self.name}.moving.svg" if self.moves else ""

    @property
    def data_script(self) -> Path | None:
        path = self.script.with_name(f"{self.name}_data.py")
        return path if path.is_file() else None

    @property
    def data(self) -> list[str]:
        return [f"build/data/{self.name}.npz"] if self.data_script else []

    @property
    def printed_text(self) -> str:
        """The text that a chapter prints with the drawing."""
        slides = ", ".join(map(str, self.slides))
        return f"{self.title} {self.caption} (slides {slides}) {self.moving}".strip()

    @property
    def stage(self) -> str:
        return self.script.parent.name


@cache
def figures() -> dict[str, Figure]:
    """All figures by name. A script under figures/ that states SLIDES is a figure."""
    by_name: dict[str, Figure] = {}
    for script in sorted(Path("figures").glob("*/*.py")):
        figure = read_figure(script)
        if figure is None:
            continue
        if figure.name in by_name:
            fault(f"Two figures are called {figure.name!r}: {by_name[figure.name].script} and {script}.")
        by_name[figure.name] = figure
    return by_name


def read_figure(script: Path) -> Figure | None:
    try:
        tree = ast.parse(text_of(script))
    except SyntaxError as error:
        fault(f"{script}, line {error.lineno}: {error.msg}.")
    except ValueError as error:
        fault(f"{script}: {error}.")
    slides, models = constants(tree, "SLIDES"), constants(tree, "MODEL")
    if not slides or script.stem.endswith("_data"):
        return None
    title, _, rest = (ast.get_docstring(tree) or "").partition("\n")
    if not title.strip():
        fault(f"{script} has no docstring: its first line is the first sentence of the caption.")
    moves = any(isinstance(node, ast.FunctionDef) and node.name == "move" for node in tree.body)
    model = model_in(models[0], script) if models else ()
    return Figure(script.stem, script, title.strip(), " ".join(rest.split()), numbers_in(slides[0], script), moves, model)


def constants(tree: ast.Module, name: str) -> list[ast.expr]:
    """The values that a script assigns to a name at its top level."""
    return [
        node.value
        for node in tree.body
        if isinstance(node, ast.Assign) and any(isinstance(t, ast.Name) and t.id == name for t in node.targets)
    ]


def model_in(node: ast.expr, script: Path) -> tuple[str, ...]:
    """MODEL is written as two strings: which, and why."""
    try:
        model = ast.literal_eval(node)
    except ValueError:
        model = None
    if not (isinstance(model, tuple) and len(model) == 2 and all(isinstance(word, str) for word in model)):
        fault(f"{script}: MODEL is two strings: which model of light, and why that was enough.")
    return model


def numbers_in(node: ast.expr, script: Path) -> tuple[int, ...]:
    """SLIDES may be written as (37, 38, 39) or with range, as in tuple(range(17, 30))."""
    allowed = {"__builtins__": {"range": range, "tuple": tuple}}
    try:
        return tuple(int(n) for n in eval(compile(ast.Expression(node), str(script), "eval"), allowed))
    except (NameError, TypeError, ValueError):
        fault(f"{script}: SLIDES is a tuple of numbers, such as (37, 38, 39) or tuple(range(17, 30)).")


def figures_of_slide(slide: int) -> list[str]:
    return [name for name, figure in figures().items() if slide in figure.slides]


def drawn_slides() -> list[int]:
    return sorted({slide for figure in figures().values() for slide in figure.slides})


# Chapters --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Chapter:
    """A chapter's file and what its cells name: figures, equations, data, library files."""

    path: Path
    code: str = field(repr=False)
    calls: dict[str, list[str]]

    @property
    def stem(self) -> str:
        return self.path.stem

    @property
    def label(self) -> str:
        return self.stem.partition("_")[0]

    def named(self, helper: str) -> list[str]:
        return list(dict.fromkeys(self.calls.get(helper, [])))


@cache
def chapters() -> dict[str, Chapter]:
    """All chapters in order: 0, 1, ..., then A, B, ... Other files in the folder are no chapter."""
    paths = [p for p in Path("chapters").glob("*.md") if re.match(r"(\d+|[A-Z])_", p.name)]
    ordered = sorted(paths, key=lambda p: (p.name[0].isalpha(), order(p.stem), p.stem))
    return {path.stem: read_chapter(path) for path in ordered}


def order(stem: str) -> int:
    label = stem.partition("_")[0]
    return int(label) if label.isdigit() else ord(label)


def body_of(text: str) -> str:
    """A chapter without its front matter, which only names the kernel for editors."""
    return FRONT.sub("", text)


def cells_of(text: str) -> list[str]:
    return [code_of(body) for body in CELL.findall(text)]


def code_of(body: str) -> str:
    """A cell without its options."""
    return OPTIONS.sub("", body)


def read_chapter(path: Path) -> Chapter:
    text = text_of(path)
    inline = ["(" + split_format(found)[0] + ")" for found in INLINE.findall(CELL.sub("", text))]
    trees = [(part, parsed(part)) for part in [*cells_of(text), *inline]]
    good = [(part, tree) for part, tree in trees if tree is not None]
    calls: dict[str, list[str]] = {}
    for part, tree in good:
        refuse_computed_names(path, part, tree)
        collect_calls(tree, calls)
    return Chapter(path, "\n".join(part for part, _ in good), calls)


def parsed(source: str) -> ast.Module | None:
    """A cell that is no Python is reported, with its place, when the chapter is executed."""
    try:
        return ast.parse(source)
    except SyntaxError:
        return None


def refuse_computed_names(path: Path, code: str, tree: ast.Module) -> None:
    """The build knows what a chapter needs only if it is written there."""
    for call in (node for node in ast.walk(tree) if isinstance(node, ast.Call)):
        helper = call.func.id if isinstance(call.func, ast.Name) else ""
        first = call.args[0] if call.args else None
        if helper in ("computed", "data", "equation", "figure") and not isinstance(first, ast.Constant):
            fault(f"{path}: {helper}(...) takes a name in quotes, or the build cannot know what is needed: {code.strip()}")


def collect_calls(tree: ast.Module, calls: dict[str, list[str]]) -> None:
    """Literal first arguments of calls by plain name: equation("key"), figure("name")..."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            texts = [a.value for a in node.args if isinstance(a, ast.Constant)]
            calls.setdefault(node.func.id, []).extend(t for t in texts if isinstance(t, str))


def split_format(inline: str) -> tuple[str, str]:
    """`100*loss:.1f` -> (`100*loss`, `.1f`), split as an f-string would."""
    depth = 0
    for place, char in enumerate(inline):
        depth += (char in "([{") - (char in ")]}")
        if char == ":" and not depth:
            return inline[:place].strip(), inline[place + 1 :].strip()
    return inline.strip(), ""
