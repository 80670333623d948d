"""The report: all chapters in order, set by the template, as one PDF.

python workflow/report.py build/report.pdf --version 1.0 --commit abc --tree clean
"""

from __future__ import annotations

import argparse
import json
import re
from collections.abc import Iterable, Iterator
from pathlib import Path

import inventory
import yaml

BUILD = Path("build")
WORKS = Path("chapters/references.bib")
ABSTRACT = "abstract"
LABEL = re.compile(r"<((?:eq|fig|tbl|sec):[^>\s]+)>")
REFERENCE = re.compile(r'#refer(?:-bare)?\(label\("([^"]+)"\)\)')
CITATION = re.compile(r"#cite\(<([^>]+)>|(?<![\w\\.])@([A-Za-z](?:[\w:-]*\w)?)")


def works() -> list[str]:
    """The keys of the bibliography."""
    return re.findall(r"^@\w+\{([^,\s]+),", WORKS.read_text("utf-8"), re.M)


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


def missing(kind: str, names: list[str], known: Iterable[str]) -> list[str]:
    known = set(known)
    return [inventory.unknown(kind, name, known) for name in dict.fromkeys(names) if name not in known]


def facts(options: argparse.Namespace) -> dict[str, object]:
    citation = yaml.safe_load(Path("CITATION.cff").read_text("utf-8"))
    return {
        "title": citation["title"],
        "authors": [author["name"] for author in citation["authors"]],
        "version": options.version,
        "commit": options.commit,
        "tree": options.tree,
        "labels": [chapter.label for chapter in inventory.chapters().values()],
        "works": works(),
    }


def main_file(stems: list[str]) -> str:
    """The Typst file that includes the chapters; appendices begin on a page of their own."""
    lines = ['#import "/workflow/template.typ": *']
    abstract = BUILD / "chapters" / f"{ABSTRACT}.typ"
    argument = f'abstract: include "/{abstract}"' if abstract.is_file() else ""
    lines.append(f"#show: report.with({argument})")
    for stem in stems:
        lines += ["#pagebreak(weak: true)"] if stem[0].isalpha() else []
        lines.append(f'#include "/build/chapters/{stem}.typ"')
    return "\n".join(lines) + "\n"


def typeset(main: Path, out: Path) -> None:
    import typst

    try:
        pdf = typst.compile(str(main), root=".", ignore_system_fonts=True)
    except typst.TypstError as error:
        inventory.stop(f"Typst could not set the report:\n{error.diagnostic}")
    inventory.write_atomically(out, pdf)


def parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    for name in ("version", "commit", "tree"):
        parser.add_argument(f"--{name}", required=True)
    return parser.parse_args()


def main() -> None:
    options = parse()
    texts = fragments()
    faults = list(loose_ends(texts, works()))
    if faults:
        inventory.stop("\n".join(faults))
    inventory.write_atomically(BUILD / "report.json", json.dumps(facts(options), indent=1, ensure_ascii=False))
    inventory.write_atomically(BUILD / "report.typ", main_file(list(texts)))
    typeset(BUILD / "report.typ", options.out)


if __name__ == "__main__":
    main()
