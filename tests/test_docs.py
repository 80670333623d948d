"""The documentation: its code runs as printed, docstrings have one form, and the site is whole and needs no network."""

from __future__ import annotations

import filecmp
import inspect
import re
import subprocess
import sys
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

import microfacet as mf
import pytest
from as_printed import run_as_printed
from microfacet.__main__ import main
from microfacet.statements.statement import Equation
from numpydoc.validate import validate

ROOT = Path(__file__).resolve().parents[1]
PAGES = {str(page.relative_to(ROOT)): page for page in [*sorted(ROOT.glob("docs/**/*.md")), ROOT / "CONTRIBUTING.md"]}
FENCE = re.compile(r"^(`{3,})([^\n]*)\n(.*?)^\1$", re.M | re.S)
MAKEFILE = (ROOT / "Makefile").read_text("utf-8")

# --- pages --------------------------------------------------------------------------------------------------------------


def blocks(page: str, language: str) -> list[str]:
    return [body for _, kind, body in FENCE.findall(PAGES[page].read_text("utf-8")) if kind == language]


def test_no_code_escapes_its_test() -> None:
    for name, page in PAGES.items():
        text = page.read_text("utf-8")
        assert {kind for _, kind, _ in FENCE.findall(text) if not kind.startswith("{")} <= {"python", "sh"}, name
        assert not re.search(r"^(    |\t)(>>>|make |\.venv)", text, re.M), name
        assert all(block.startswith(">>> ") for block in blocks(name, "python")), name


@pytest.mark.parametrize("page", [page for page in PAGES if blocks(page, "python")])
def test_code_of_a_page_runs_as_printed(page: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """From top to bottom, in a checkout."""
    monkeypatch.chdir(ROOT)
    run_as_printed("\n".join(blocks(page, "python")), page)


@pytest.mark.parametrize("page", [page for page in PAGES if blocks(page, "sh")])
def test_commands_of_a_page_exist(page: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    for line in "".join(blocks(page, "sh")).splitlines():
        command, *words = line.removeprefix(".venv/bin/").split()
        if command == "make":
            assert re.search(rf"^{words[0]}:", MAKEFILE, re.M), line
        elif command == "snakemake":
            assert [*ROOT.glob(f"figures/*/{words[0]}.py")], line
        elif command == "pytest":
            assert (ROOT / words[0]).is_file(), line
        else:
            assert command == "microfacet", line
            assert main(words) == 0, line


# --- docstrings ---------------------------------------------------------------------------------------------------------

UNASKED = {  # of numpydoc's checks: matters of taste, and sections that not everything needs
    *("GL01", "GL02"),  # where the quotes stand
    *("ES01", "SA01"),  # an extended summary, See Also
    *("SS05",),  # an imperative: what gives a value is named by it
}


def objects() -> Iterator[tuple[str, Any]]:
    """Public classes and functions, and the public methods of these classes, each where it is defined.

    A method that needs no other words than the one it overrides has none, and inherits them.
    """
    found: set[Any] = set()
    for name in mf.PUBLIC:
        thing = getattr(mf, name)
        thing = thing if inspect.isclass(thing) or inspect.isfunction(thing) else type(thing)
        for one in (thing, Equation) if name == "equations" else (thing,):
            yield f"{one.__module__}.{one.__qualname__}", one
            for cls in one.__mro__ if inspect.isclass(one) else ():
                for word, method in vars(cls).items() if cls.__module__.startswith("microfacet") else ():
                    defined_here = getattr(method, "__qualname__", "") == f"{cls.__qualname__}.{word}"
                    if inspect.isfunction(method) and defined_here and not word.startswith("_") and method not in found:
                        found.add(method)
                        if method.__doc__ is None and inspect.getdoc(getattr(one, word)):
                            continue
                        yield f"{method.__module__}.{method.__qualname__}", method


OBJECTS = dict(sorted(objects()))


@pytest.mark.parametrize("name", OBJECTS)
def test_a_docstring_has_numpydocs_form(name: str) -> None:
    errors = [fault for fault in validate(name)["errors"] if fault[0] not in UNASKED]
    assert not errors


@pytest.mark.parametrize("name", OBJECTS)
def test_examples_of_a_docstring_run(name: str) -> None:
    run_as_printed(inspect.getdoc(OBJECTS[name]) or "", name)


def test_statements_and_sources_that_docstrings_name_exist() -> None:
    keys = set(re.findall(r"^@\w+\{(\w+),", (ROOT / "chapters/references.bib").read_text("utf-8"), re.M))
    for name, thing in OBJECTS.items():
        text = inspect.getdoc(thing) or ""
        stated = re.findall(r"``((?:geometry|visibility|material|brdf|validation)\.[\w.]+)``", text)
        assert set(stated) <= set(mf.equations), name
        assert set(re.findall(r"\b[a-z]+(?:19|20)\d\d\b", text)) <= keys, name


def test_help_shows_the_arguments_of_a_constructor() -> None:
    assert [*inspect.signature(mf.GGX).parameters] == ["alpha_x", "alpha_y"]
    assert [*inspect.signature(mf.Schlick).parameters] == ["F0", "F90"]


# --- the site -----------------------------------------------------------------------------------------------------------

OFFLINE = """if True:
    import socket, sys
    def refuse(*_): raise SystemExit("The build asks for the network.")
    socket.socket.connect = socket.getaddrinfo = refuse
    from sphinx.cmd.build import main
    sys.exit(main(sys.argv[1:]))"""


def built(folder: Path) -> Path:
    """The site as `make docs` builds it, without a network."""
    (command,) = re.findall(r"\$\(BIN\)/sphinx-build (.*)", MAKEFILE)
    options = command.replace("build/docs", str(folder / "site")).replace("build/doctrees", str(folder / "doctrees"))
    done = subprocess.run(
        [sys.executable, "-c", OFFLINE, *options.split()], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "WARNING" not in done.stderr
    return folder / "site"


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return built(tmp_path_factory.mktemp("docs"))


class Page(HTMLParser):
    """What a page names: places in it, links, and files it loads."""

    LOADED = (("script", "src"), ("img", "src"), ("source", "src"), ("iframe", "src"), ("object", "data"))

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.places, self.links, self.loaded = {""}, list[str](), list[str]()
        self.feed(path.read_text("utf-8"))

    def handle_starttag(self, tag: str, pairs: list[tuple[str, str | None]]) -> None:
        given = {name: value or "" for name, value in pairs}
        self.places |= {given[name] for name in ("id", "name") if name in given}
        if tag == "a" and "href" in given:
            self.links.append(given["href"])
        elif tag == "link" and "href" in given:
            self.loaded.append(given["href"])
        self.loaded += [given[name] for kind, name in self.LOADED if kind == tag and name in given]


@pytest.mark.slow
def test_the_site_has_a_page_for_each_public_name(site: Path) -> None:
    for name in mf.PUBLIC:
        assert f"microfacet.{name}" in Page(site / f"reference/api/microfacet.{name}.html").places


@pytest.mark.slow
def test_the_site_loads_nothing_from_outside(site: Path) -> None:
    for path in site.rglob("*.html"):
        assert not [one for one in Page(path).loaded if urlsplit(one).netloc or urlsplit(one).scheme not in ("", "data")], path
    for path in site.rglob("*.css"):
        assert not re.search(r"url\(\s*[\"']?(https?:)?//|@import", path.read_text("utf-8")), path


@pytest.mark.slow
def test_links_of_the_site_lead_somewhere(site: Path) -> None:
    pages = {path.resolve(): Page(path) for path in site.rglob("*.html")}
    for path, page in pages.items():
        for link in (*page.links, *page.loaded):
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            assert target.is_file(), f"{path}: {link}"
            if target in pages and target.name != "search.html":
                assert unquote(parts.fragment) in pages[target].places, f"{path}: {link}"


@pytest.mark.slow
def test_two_builds_give_the_same_bytes(site: Path, tmp_path: Path) -> None:
    again = built(tmp_path)
    files = sorted(str(path.relative_to(site)) for path in site.rglob("*") if path.is_file())
    assert files == sorted(str(path.relative_to(again)) for path in again.rglob("*") if path.is_file())
    assert filecmp.cmpfiles(site, again, files, shallow=False)[0] == files
