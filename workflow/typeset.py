"""The report: all chapters in order, set by the template, as one PDF or as one HTML file that fetches nothing.

python workflow/typeset.py build/report.pdf --version 1.0 --commit abc --tree clean
python workflow/typeset.py build/report.html --version 1.0 --commit abc --tree clean
"""

from __future__ import annotations

import argparse
import json
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import inventory
import seal
import web
import yaml

BUILD = Path("build")
WORKS = Path("chapters/references.bib")
ABSTRACT = "abstract"
LABEL = re.compile(r"<((?:eq|fig|tbl|sec):[^>\s]+)>")
REFERENCE = re.compile(r'#refer(?:-bare)?\(label\("([^"]+)"\)\)')
EXPERIMENTAL = "html export is under active development"
CITATION = re.compile(r"#cite\(<([^>]+)>|(?<![\w\\.])@([A-Za-z](?:[\w:-]*\w)?)")


def works() -> list[str]:
    """The keys of the bibliography."""
    return re.findall(r"^@\w+\{([^,\s]+),", inventory.text_of(WORKS), re.M)


def fragments() -> dict[str, str]:
    """The chapters' Typst by the name of the chapter, in order."""
    return {stem: (BUILD / "chapters" / f"{stem}.typ").read_text("utf-8") for stem in inventory.chapters()}


def loose_ends(texts: dict[str, str], known_works: list[str]) -> Iterator[str]:
    """One sentence for each label given twice, reference to nothing, or work not in the bibliography."""
    homes: dict[str, str] = {}
    for stem, text in texts.items():
        for label in LABEL.findall(text):
            if label in homes:
                yield f"chapters/{stem}.md labels {label} again; it stands in chapters/{homes[label]}.md."
            homes[label] = stem
    for stem, text in texts.items():
        works_cited = [first or second for first, second in CITATION.findall(text)]
        for sentence in [*missing("label", REFERENCE.findall(text), homes),
                         *missing(f"work in {WORKS}", works_cited, known_works)]:  # fmt: skip
            yield f"chapters/{stem}.md: {sentence}"


def labels(texts: dict[str, str]) -> list[str]:
    return [label for text in texts.values() for label in LABEL.findall(text)]


def missing(kind: str, names: list[str], known: Iterable[str]) -> list[str]:
    known = set(known)
    return [inventory.unknown(kind, name, known) for name in dict.fromkeys(names) if name not in known]


def cited(path: Path) -> dict[str, object]:
    try:
        citation = yaml.safe_load(inventory.text_of(path))
        return {"title": citation["title"], "authors": [author["name"] for author in citation["authors"]]}
    except (yaml.YAMLError, LookupError, TypeError):
        inventory.stop(f"{path} must name a title, and authors each by a name.")


def facts(options: argparse.Namespace) -> dict[str, object]:
    return {
        **cited(Path("CITATION.cff")),
        "version": options.version,
        "commit": options.commit,
        "tree": options.tree,
        "labels": [chapter.label for chapter in inventory.chapters().values()],
        "works": works(),
    }


def medium_of(out: Path) -> str:
    """What the template is to make, by the ending of the file."""
    return "web" if out.suffix == ".html" else "page"


def main_file(stems: list[str], medium: str) -> str:
    """The Typst file that includes the chapters; on paper, appendices begin on a page of their own."""
    lines = ['#import "/workflow/template.typ": *']
    abstract = BUILD / "chapters" / f"{ABSTRACT}.typ"
    argument = f'abstract: include "/{abstract}"' if abstract.is_file() else ""
    lines.append(f"#show: report.with({argument})")
    for stem in stems:
        lines += ["#pagebreak(weak: true)"] if medium == "page" and stem[0].isalpha() else []
        lines.append(f'#include "/build/chapters/{stem}.typ"')
    return "\n".join(lines) + "\n"


def typeset(source: Path, medium: str) -> bytes:
    """The report in its bytes. What Typst would leave out of the web page, or cannot find, stops the build."""
    import typst

    form: Any = {"page": "pdf", "web": "html"}[medium]
    options: Any = {"root": ".", "format": form, "ignore_system_fonts": True, "sys_inputs": {"medium": medium}}
    try:
        made, warnings = typst.compile_with_warnings(str(source), **options)
    except typst.TypstError as error:
        inventory.stop(f"Typst could not set the report:\n{error.diagnostic}")
    doubts = [warning.diagnostic for warning in warnings if EXPERIMENTAL not in warning.message]
    if doubts:
        inventory.stop("Typst set the report with doubts:\n" + "\n".join(doubts))
    return web.finished(made) if medium == "web" else made


def parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    for name in ("version", "commit", "tree"):
        parser.add_argument(f"--{name}", required=True)
    return parser.parse_args()


def refuse_broken_parts(medium: str) -> None:
    """Stop if a part is torn: otherwise the chapter or Typst would be blamed. Moving drawings are for the web only."""
    known = inventory.figures()
    displayed = [known[name] for one in inventory.chapters().values() for name in one.named("figure") if name in known]
    texts = [BUILD / "chapters" / f"{stem}.typ" for stem in (*inventory.chapters(), ABSTRACT)]
    pictures = [BUILD / "figures" / f"{figure.name}.svg" for figure in displayed]
    moving = [Path(figure.moving) for figure in displayed if figure.moves and medium == "web"]
    try:
        seal.refuse_broken([*texts, *pictures, *moving, BUILD / "ledger.json"])
    except ValueError as fault:
        inventory.stop(str(fault))


def main() -> None:
    options = parse()
    medium = medium_of(options.out)
    refuse_broken_parts(medium)
    texts = fragments()
    faults = list(loose_ends(texts, works()))
    if faults:
        inventory.stop("\n".join(faults))
    inventory.write_atomically(BUILD / "report.json", json.dumps(facts(options), indent=1, ensure_ascii=False))
    source = BUILD / f"{medium}.typ"
    inventory.write_atomically(source, main_file(list(texts), medium))
    made = typeset(source, medium)
    faults = list(web.faults(made.decode(), labels(texts))) if medium == "web" else []
    if faults:
        inventory.stop("\n".join(faults))
    inventory.write_atomically(options.out, made)


if __name__ == "__main__":
    main()
