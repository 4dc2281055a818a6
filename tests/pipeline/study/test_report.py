"""The reproduction report: complete, self-contained, the same bytes from the same stores, docs/physics.md's numbers."""

import base64
import re
import shlex
from html.parser import HTMLParser

import pytest

from pipeline.__main__ import main
from pipeline.config.compose import compose
from pipeline.study.report import document, sources_of, write
from pipeline.study.report.html import html
from pipeline.study.report.markdown import markdown

SMALL = ["plane.sweep.num=60", "plane.parameter.num=12", "cluster=none"]
SHORT = ["attractors.columns=12", "attractors.rows=4", "attractors.starts=1"]
VOID = {"br", "meta", "img"}


class Page(HTMLParser):
    """Checks that elements nest, and gathers images, links, identifiers and the cells of tables."""

    def __init__(self, text: str):
        super().__init__(convert_charrefs=True)
        self.open, self.images, self.links, self.names, self.rows, self.seen = [], [], [], [], [], []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        attributes = dict(attrs)
        assert len(attributes) == len(attrs), f"{tag} repeats an attribute"
        self.seen.append(tag)
        self.names += [attributes["id"]] if "id" in attributes else []
        if tag == "img":
            self.images.append((attributes["src"], attributes["alt"]))
        if tag == "a":
            self.links.append(attributes["href"])
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self.rows[-1].append("")
        if tag == "br":
            self.rows[-1][-1] += "\n"
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open and self.open.pop() == tag, f"</{tag}> closes something else"

    def handle_data(self, data):
        if {"td", "th"} & set(self.open):
            self.rows[-1][-1] += data


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A folder in which one command has made everything."""
    folder = tmp_path_factory.mktemp("report")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        assert main(["stages=[report]", "report.run=true", *SMALL, *SHORT]) == 0
    return folder


@pytest.fixture(scope="module")
def page(made):
    return (made / "outputs/report/report.html").read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_page_is_valid_and_needs_nothing_else(page):
    parsed = Page(page)
    assert page.startswith("<!DOCTYPE html>") and parsed.seen.count("main") == parsed.seen.count("h1") == 1
    assert len(set(parsed.names)) == len(parsed.names) >= 7
    assert parsed.links and {link.removeprefix("#") for link in parsed.links} <= set(parsed.names)
    assert not re.search(r"""(?:https?:)?//[a-z]|url\(|@import|<script|<link""", re.sub(r"base64,[^\"]*", "", page))
    assert len(parsed.images) == 12
    for source, alternative in parsed.images:
        kind, data = source.split(",", 1)
        assert kind == "data:image/png;base64" and base64.b64decode(data, validate=True).startswith(b"\x89PNG")
        assert len(alternative) > 10


@pytest.mark.slow
def test_thresholds_are_those_of_physics(page):
    """Our column of docs/physics.md, section 7, to its printed digits."""
    rows = {row[0]: row for row in Page(page).rows}
    expected = {
        "Ω × b: at the mesh resonance 2/0-2 is gone above b": (1.011,),
        "Ω × b: the shaft resonance settles above b, double-sided impact is gone": (0.18,),
        "Ω × f_e: at the shaft resonance 1/0 gives way to 1/1 at f_e": (0.140,),
        "Ω × f_e: at the mesh resonance 2/0-2 appears at f_e": (0.198,),
        "Ω × f_e: at the mesh resonance 2/1-2 and 2/2 appear at f_e": (0.321, 0.370),
        "Ω × α: jumps at the shaft resonance end at α": (0.278,),
        "Ω × α: contact loss at the shaft resonance ends at α": (0.388,),
        "Ω × f_pm: jumps at the shaft resonance end at f_pm": (0.5855,),
        "Ω × f_pm: contact loss at the shaft resonance ends at f_pm": (0.714,),
        "default parameters: several motions at the mesh resonance in an interval of Ω": (0.55937, 0.63464),
        "default parameters: several motions at the shaft resonance in an interval of Ω": (1.22381, 1.22971),
    }
    for text, values in expected.items():
        _, _, here, reference, verdict = rows[text]
        ours = [float(value) for value in re.split(", |–", here)]
        for value, digits in zip(ours, values, strict=True):
            # Four digits are printed.
            places = min(len(f"{digits}".partition(".")[2]), 4)
            assert abs(value - digits) < 0.6 * 10.0**-places, text
        assert [float(value) for value in re.split(", |–", reference)] == pytest.approx(values, abs=0.0)
        assert re.match("agrees: within 5 %|differs: by more than 5 %", verdict), text
    digits = [row for row in rows.values() if ": all solutions at" in row[0] or re.match(r"\w+: (no )?folds", row[0])]
    assert len(digits) == 9 and all(row[3].startswith("agrees") for row in digits)


@pytest.mark.slow
def test_the_first_paragraph_says_what_agrees_and_what_cannot_hold(page):
    first = re.search(r"<p>(.*?)</p>", page)[1]
    verdicts = [row[4] for row in Page(page).rows if len(row) == 5 and row[4].startswith(("agrees", "differs"))]
    agree = sum(verdict.startswith("agrees") for verdict in verdicts)
    assert len(verdicts) == 15 and first.startswith(f"Of the 15 statements of the article {agree} agree")
    for said in ("σ = 0.3173", "c = 0.7719", "ratio 0.240", "ratio 0.267", "(b)", "Ω = 1.59", "(c)", "I = 1"):
        assert said in first


@pytest.mark.slow
def test_the_closing_commands_run_as_they_stand(made, monkeypatch, capsys):
    """Every one of them, as typed into a shell; nothing is left to do, so that the page is the same."""
    monkeypatch.chdir(made)
    before = (made / "outputs/report/report.md").read_bytes()
    commands = before.decode().split("## How this page was made")[1].split("```")[1].strip().splitlines()
    assert len(commands) == 7
    for command in commands:
        python, *arguments = shlex.split(command)
        assert python == "python" and arguments[:2] == ["-m", "pipeline"]
        assert main(arguments[2:]) == 0, command
    said = capsys.readouterr().out
    assert said.count("nothing to do") >= 6 and "report.html" in said
    assert (made / "outputs/report/report.md").read_bytes() == before


@pytest.mark.slow
def test_everything_that_was_promised_is_there(page, made):
    text = (made / "outputs/report/report.md").read_text(encoding="utf-8")
    for heading in (
        "The numbers: article, here, reference",
        "What differs, and why",
        "Tables 1 to 3",
        "Maps and curves",
        "What other readings of the model change",
        "How far first order can be trusted",
        "Appendix: what was measured",
        "How this page was made",
    ):
        assert f">{heading}<" in page and f"## {heading}\n" in text
    assert "consistent" in text and "antiphase" in text and "numpy" in text and "configuration" in text.lower()
    for command in ("plane=omega_b", "gear=antiphase", "stages=[report]"):
        assert command in text
    for name in re.findall(r"\]\((figures/[^)]+)\)", text):
        assert (made / "outputs/report" / name).read_bytes().startswith(b"\x89PNG")
    assert str(made) not in page


@pytest.mark.slow
def test_the_same_stores_give_the_same_bytes(made, monkeypatch):
    monkeypatch.chdir(made)
    first = {path.name: path.read_bytes() for path in (made / "outputs/report").rglob("*") if path.is_file()}
    sources = sources_of(["stages=[report]", *SMALL, *SHORT])
    text = (made / "outputs/report/report.md").read_text(encoding="utf-8")
    command = text.split("## How this page was made")[1].split("```")[1].strip().splitlines()[-1]
    again = write(sources, made / "again", command)
    assert {path.name: path.read_bytes() for path in again} == first


@pytest.mark.parametrize(
    ("typed", "said"),
    [("stages=[report]", "report.run=true"), ("stages=[report] gear=antiphase", "gear = 'antiphase' is not allowed")],
)
def test_what_is_missing_is_one_line(typed, said, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(typed.split(" ")) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1 and lines[0].startswith("error: ") and said in lines[0]
    assert list(tmp_path.iterdir()) == []


def test_planes_of_the_report_keep_what_is_not_their_own():
    sources = sources_of(["stages=[report]", "quality=draft", "store.root=there", "figures.dpi=90", "report.run=true"])
    kinds = [(source.plane, source.gear) for source in sources]
    assert kinds[:2] == [("omega_fe", "published"), ("omega_b", "published")]
    for source in sources:
        assert source.path.parent.name == "there" and source.path.stem.endswith("-draft")
        assert "figures" not in source.command and "report" not in source.command
        composed = compose(shlex.split(source.command.removeprefix("python -m pipeline ")))
        assert composed.store_path == source.settings.store_path


def test_text_is_never_markup():
    nasty = '<b>1</b> & "x" | *y* `z`'
    blocks = (
        document.Heading(nasty),
        document.Paragraph(nasty),
        document.Bullets((nasty,)),
        document.Grid(nasty, (nasty,), ((nasty,),)),
        document.Picture("p", nasty, b"\x89PNG"),
        document.Listing(nasty, nasty),
    )
    made = document.Document(nasty, blocks)
    parsed = Page(html(made))
    assert "b" not in parsed.seen and parsed.rows[0] == [nasty]
    assert "| <b>" not in markdown(made) and "\n```\n" + nasty in markdown(made)
