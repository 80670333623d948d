"""The web page is complete by itself, says what the pages on paper say, and can be read on any screen."""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Iterator
from html import unescape
from pathlib import Path

import browser
import pytest
import typeset
import web
from checkout import Checkout

pytestmark = pytest.mark.slow  # a page is built, and read in a browser

HTML = "build/report.html"
REAL = Path(__file__).resolve().parents[2] / HTML


@pytest.fixture(scope="module")
def page(built: Checkout) -> str:
    return built.path(HTML).read_text("utf-8")


def labels(checkout: Checkout) -> list[str]:
    texts = [path.read_text("utf-8") for path in sorted(checkout.path("build/chapters").glob("*.typ"))]
    return [label for text in texts for label in typeset.LABEL.findall(text)]


def words(piece: str) -> str:
    """What a piece of the page says, formulae left out."""
    told = re.sub(r"<svg.*?</svg>|<math.*?</math>|<style.*?</style>|<script.*?</script>", "", piece, flags=re.S)
    return " ".join(unescape(re.sub(r"<[^>]+>", "", told)).replace("\xa0", " ").split())


# Without a browser ------------------------------------------------------------------------------


def test_the_page_is_complete(page: str, built: Checkout) -> None:
    expected = labels(built)
    assert len(expected) >= 8
    assert list(web.faults(page, expected)) == []
    found = web.Contents(page)
    assert len(found.pictures) == sum(label.startswith("fig:") for label in expected)
    assert found.pictures["fig:masking"] == 2  # at rest and in motion
    assert found.tags["math"] == found.classes["drawn"] == found.tags["svg"]


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ('id="eq:visibility.G1"', 'id="eq:other"', "eq:visibility.G1 is not on the page."),
        ('href="#eq:visibility.G1"', 'href="#eq:none"', "The link '#eq:none' leads nowhere."),
        ('src="data:image/svg+xml', 'src="https://example.org/a.svg?', "The page would fetch 'https://example.org/a.svg?"),
        ("</head>", '<link rel="stylesheet" href="look.css"></head>', "The page would fetch 'look.css'."),
        (":root {", "@import 'look.css'; :root {", "The page would fetch \"'look.css'\"."),
        (":root {", "@font-face { src: url(type.woff) } :root {", "The page would fetch 'type.woff'."),
        ('id="fig:masking"', 'id="sec:values"', "The address 'sec:values' is given 2 times."),
    ],
)
def test_what_is_broken_is_told(page: str, built: Checkout, old: str, new: str, sentence: str) -> None:
    assert old in page
    assert any(told.startswith(sentence.rstrip(".'")) for told in web.faults(page.replace(old, new), labels(built)))


def test_a_figure_without_picture_and_an_equation_without_drawing_are_told(page: str, built: Checkout) -> None:
    bare = re.sub(r"<svg.*?</svg>", "", re.sub(r"<img[^>]*>", "", page), flags=re.S)
    told = set(web.faults(bare, labels(built)))
    assert {"fig:masking has no picture.", "eq:visibility.G1 is not drawn."} <= told


def test_numbers_and_references_agree(page: str) -> None:
    """A reference prints the number that stands at its target."""
    shown = {
        ident: re.search(r'class="number">(.*?)(?:<span|</div>)', rest, re.S)
        for ident, rest in re.findall(r'id="(eq:[^"]+)"(.*?)(?=id="(?:eq|sec|fig|tbl):|</main>)', page, re.S)
    }
    for ident, word, number in re.findall(r'<a href="#(eq:[^"]+)">(Eq\.\W)?(\([\w.]+\))</a>', page):
        at = shown[ident]
        assert at, word
        assert words(at[1]) == number
    assert len(shown) == 3
    captions = dict(re.findall(r'id="((?:fig|tbl):[^"]+)".*?<figcaption><b>(.*?)\.</b>', page, re.S))
    for ident, text in re.findall(r'<a href="#((?:fig|tbl):[^"]+)">([^<]*\w)</a>', page):
        assert words(captions[ident]).endswith(words(text).split()[-1])


def test_marks_slides_and_works_are_there(page: str) -> None:
    told = words(page)
    assert re.search(r'id="eq:visibility\.G1".*?<span class="good">✓ [SRBENM]', page, re.S)
    assert "(slides 37–39)" in told or "slide" in told
    assert "Figures by slide" in told
    assert "References" in told
    assert "visibility.Lambda" in told


def test_glyphs_are_drawn_once(page: str) -> None:
    names = re.findall(r'<symbol id="([^"]+)"', page)
    assert len(names) == len(set(names))
    assert set(re.findall(r'xlink:href="#([^"]+)"', page)) <= set(names)


@pytest.mark.parametrize(("before", "after"), [("", ","), ("(", ")."), ("([", ""), ("", "")])
def test_a_formula_keeps_what_touches_it(before: str, after: str) -> None:
    text = f'{before}<span class="formula">a</math></span></span>{after}'
    whole = f'<span class="whole">{text}</span>' if after else text
    assert web.unbroken(f"word {text} word".encode()) == f"word {whole} word".encode()


def test_what_typst_leaves_out_stops_the_build(small: Checkout) -> None:
    source = small.path("build/web.typ")
    source.parent.mkdir(exist_ok=True)
    source.write_text("#place(top)[lost]\n")
    with pytest.raises(SystemExit) as stop:
        typeset.typeset(Path("build/web.typ"), "web")
    assert "place was ignored" in str(stop.value)


# In a browser -----------------------------------------------------------------------------------

SCREENS = [(390, 844, "light"), (390, 844, "dark"), (1200, 900, "light"), (1200, 900, "dark")]
HIDDEN = """[...document.querySelectorAll(".drawn svg, .picture img")].filter(e => {
  const box = e.getBoundingClientRect();
  return e.checkVisibility() ? box.width < 2 || box.height < 2 : !e.closest(".moves");
}).length"""
ABROAD = """[...document.querySelectorAll("body *")].filter(e => e.getBoundingClientRect().right > innerWidth + 1
  && !e.closest(".scroll, pre, .spoken")).map(e => e.outerHTML.slice(0, 80))"""
CONTRAST = """(() => {
  const light = ([r, g, b]) => [r, g, b].map(v => v / 255).map(v => v <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4)
    .reduce((sum, v, k) => sum + v * [0.2126, 0.7152, 0.0722][k], 0);
  const numbers = colour => colour.match(/[0-9.]+/g).map(Number);
  const paper = light(numbers(getComputedStyle(document.body).backgroundColor));
  return Math.min(...["body", "a", ".good", ".quiet", "h2"].map(name => {
    const ink = light(numbers(getComputedStyle(document.querySelector(name)).color));
    return (Math.max(ink, paper) + 0.05) / (Math.min(ink, paper) + 0.05);
  }));
})()"""


@pytest.fixture(scope="module")
def open_page(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Callable[..., browser.Page]]:
    program = browser.program()
    if program is None:
        pytest.skip(f"no browser: none of {', '.join(browser.PROGRAMS)} is on this machine (MICROFACET_BROWSER names another)")
    shown = browser.Page(program, tmp_path_factory.mktemp("profile"))

    def open_page(path: Path, width: int, height: int, **media: str) -> browser.Page:
        shown.events.clear()
        shown.look(width, height, **media)
        shown.open(path)
        return shown

    yield open_page
    shown.close()


@pytest.fixture(params=["small", "real"])
def path(request: pytest.FixtureRequest) -> Path:
    if request.param == "small":
        return Path(request.getfixturevalue("built").path(HTML))
    if not REAL.exists():
        pytest.skip(f"{HTML} has not been made: run make report")
    return REAL


@pytest.mark.slow
@pytest.mark.parametrize(("width", "height", "scheme"), SCREENS)
def test_every_screen_shows_everything(
    open_page: Callable[..., browser.Page], path: Path, width: int, height: int, scheme: str
) -> None:
    shown = open_page(path, width, height, prefers_color_scheme=scheme)
    assert shown.faults() == []
    assert shown.requests() == [path.resolve().as_uri()]
    assert shown.run(HIDDEN) == 0
    assert shown.run(ABROAD) == []
    assert shown.run("document.documentElement.scrollWidth") <= width
    assert shown.run(CONTRAST) >= 4.5


@pytest.mark.slow
def test_the_theme_is_chosen_and_kept(open_page: Callable[..., browser.Page], built: Checkout) -> None:
    shown = open_page(built.path(HTML), 1200, 900, prefers_color_scheme="light")
    ground, choose = "getComputedStyle(document.body).backgroundColor", 'document.querySelector(".theme").click()'
    light = shown.run(ground)
    for patience in (0.5, 2, 5, 10):  # a browser keeps what a page hands it in its own time, or not if the page is left at once
        for _ in range(3):
            if "dark" not in shown.run('document.querySelector(".theme").textContent'):
                shown.run(choose)
        dark = shown.run(ground)
        assert dark != light
        time.sleep(patience)
        shown.open(built.path(HTML))
        if shown.run(ground) == dark:
            break
    else:
        pytest.fail("the page forgot its theme")
    shown.run(choose)
    assert shown.run(ground) == light


@pytest.mark.slow
def test_motion_is_shown_to_those_who_want_it(open_page: Callable[..., browser.Page], path: Path) -> None:
    seen = """[...document.querySelectorAll(".moves")].map(e => [".still", ".moving"]
      .map(name => e.querySelector(name).checkVisibility()).join()).filter((v, k, all) => all.indexOf(v) === k).join(" ")"""
    shown = open_page(path, 1200, 900, prefers_reduced_motion="no-preference")
    assert shown.run(seen) == "false,true"
    shown.run('document.querySelectorAll(".motion").forEach(button => button.click())')
    assert shown.run(seen) == "true,false"
    shown = open_page(path, 1200, 900, prefers_reduced_motion="reduce")
    assert shown.run(seen) == "true,false"
    assert shown.run('document.querySelectorAll(".motion").length') == 0


@pytest.mark.slow
@pytest.mark.parametrize(("width", "height"), [(390, 844), (1200, 900)])
def test_figures_enlarge(open_page: Callable[..., browser.Page], built: Checkout, width: int, height: int) -> None:
    shown = open_page(built.path(HTML), width, height)
    before = shown.run('document.querySelector(".moving img").getBoundingClientRect().width')
    shown.run('document.querySelector(".moving img").click()')
    shown.run("new Promise(done => setTimeout(done, 300))")
    size = 'document.querySelector("dialog[open] img").getBoundingClientRect().width'
    opened = shown.run(size)
    assert opened > before
    shown.run('[...document.querySelectorAll("dialog button")].find(b => b.textContent === "+").click()')
    assert shown.run(size) > 1.4 * opened
    shown.run('[...document.querySelectorAll("dialog button")].find(b => b.textContent === "Close").click()')
    assert shown.run('document.querySelector("dialog[open]")') is None
    assert shown.faults() == []
