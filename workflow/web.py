"""The web page after Typst: each glyph once, formulae unbroken, and checks before it is published."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator
from html.parser import HTMLParser

GLYPH = re.compile(rb'<symbol id="([^"]+)".*?</symbol>', re.S)
TOUCHED = re.compile(rb'[(\[]*<span class="formula"(?:(?!</math>).)*</math></span></span>[)\].,;:!?]+', re.S)
LOADING = ("src", "srcset", "data", "poster", "action", "background")
STYLED = re.compile(r"url\(\s*['\"]?(?!data:|#)([^)'\"]*)|@import\s+([^;]+)")
INLINE = ("data:", "#")


def finished(page: bytes) -> bytes:
    return unbroken(once_each(page))


def once_each(page: bytes) -> bytes:
    """The page with each glyph drawn once for all formulae: their names are digests of their outlines."""
    known_glyphs: set[bytes] = set()

    def first(match: re.Match[bytes]) -> bytes:
        known = match[1] in known_glyphs
        known_glyphs.add(match[1])
        return b"" if known else match[0]

    return GLYPH.sub(first, page).replace(b"<defs></defs>", b"")


def unbroken(page: bytes) -> bytes:
    """The page with each formula in a line of text kept together with the brackets and stops that touch it."""
    return TOUCHED.sub(rb'<span class="whole">\g<0></span>', page)


class Contents(HTMLParser):
    """What a page holds: addresses, links, what it would load, and how often each class of element."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.ids: list[str] = []
        self.links: list[str] = []
        self.loads: list[str] = []
        self.classes: Counter[str] = Counter()
        self.tags: Counter[str] = Counter()
        self.pictures: dict[str, int] = {}
        self.drawn: dict[str, int] = {}
        self.open: list[tuple[str, str]] = []
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = {name: value or "" for name, value in attrs}
        self.tags[tag] += 1
        self.classes.update(given.get("class", "").split())
        self.ids += [given["id"]] if "id" in given else []
        self.links += [given["href"]] if tag == "a" and "href" in given else []
        names = LOADING if tag == "a" else (*LOADING, "href", "xlink:href")
        self.loads += [given[name] for name in names if given.get(name) and not given[name].startswith(INLINE)]
        self.loads += addresses(given.get("style", ""))
        home = next((ident for _, ident in reversed(self.open) if ident.startswith(("fig:", "eq:"))), "")
        if tag == "img" and given.get("src", "").startswith("data:image/"):
            self.pictures[home] = self.pictures.get(home, 0) + 1
        if tag == "svg":
            self.drawn[home] = self.drawn.get(home, 0) + 1
        if tag not in VOID:
            self.open.append((tag, given.get("id", "")))

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        self.handle_endtag(tag)

    def handle_endtag(self, tag: str) -> None:
        while self.open and self.open.pop()[0] != tag:
            pass

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1][0] == "style":
            self.loads += addresses(data)


VOID = {"meta", "img", "br", "hr", "wbr", "input", "link", "source", "col"}


def addresses(style: str) -> list[str]:
    """What a style sheet would fetch."""
    return [first or second for first, second in STYLED.findall(style)]


def faults(page: str, labels: Iterable[str]) -> Iterator[str]:
    """One sentence for each thing that is missing from the page, duplicated, or fetched from elsewhere."""
    contents = Contents(page)
    counted = Counter(contents.ids)
    yield from (f"The address {name!r} is given {n} times." for name, n in counted.items() if n > 1)
    yield from (f"The link {link!r} leads nowhere." for link in sorted(set(contents.links)) if dangling(link, counted))
    yield from (f"The page would fetch {what!r}." for what in contents.loads)
    for label in labels:
        if label not in counted:
            yield f"{label} is not on the page."
        elif label.startswith("fig:") and not contents.pictures.get(label):
            yield f"{label} has no picture."
        elif label.startswith("eq:") and not contents.drawn.get(label):
            yield f"{label} is not drawn."


def dangling(link: str, known: Counter[str]) -> bool:
    return link.startswith("#") and link[1:] not in known
