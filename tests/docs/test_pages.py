"""What README.md and the pages name exists: files, sections, pages; physics.md prints the digits of other tests."""

import re
import runpy
import tomllib
from xml.etree import ElementTree

import pytest
import yaml

from tests.docs.examples import PAGES, name_of
from tests.docs.page import DOCS, PHYSICS, ROOT, table

SOURCES = [
    path
    for folder in ("solver", "pipeline", "tests", "benchmarks", "conf")
    for path in sorted((ROOT / folder).rglob("*"))
    if path.suffix in (".py", ".yaml")
]
CITED = re.compile(r"docs/physics\.md, sections? ([\d.]+(?:(?:, | and | to )[\d.]*\d)*)")


def slug(heading):
    """The anchor of a heading, as GitHub and MyST make it."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def anchors(text):
    return {slug(heading) for heading in re.findall(r"^#+ (.*)$", text, flags=re.MULTILINE)}


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_files_that_a_page_names_exist(page):
    names = re.findall(r"`((?:solver|pipeline|tests|conf|docs|benchmarks)/[\w./-]*)`", page.read_text(encoding="utf-8"))
    assert [name for name in names if name != "docs/_build" and not (ROOT / name).exists()] == []


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_links_lead_somewhere(page):
    text = page.read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if target.startswith("http"):
            continue
        file, _, anchor = target.partition("#")
        there = text if not file else None
        if file:
            assert (page.parent / file).is_file(), target
            there = (page.parent / file).read_text(encoding="utf-8") if file.endswith(".md") else None
        assert not anchor or anchor in anchors(there), target


def test_sections_that_the_code_cites_exist():
    sections = set(re.findall(r"^##+ ([\d.]*\d)\.? ", PHYSICS, flags=re.MULTILINE))
    assert {str(number) for number in range(1, 11)} <= sections
    cited = {
        (path.relative_to(ROOT).as_posix(), number)
        for path in SOURCES
        for place in CITED.findall(re.sub(r"\s*\n\s*#?\s*", " ", path.read_text(encoding="utf-8")))
        for number in re.findall(r"[\d.]*\d", place)
    }
    assert [(path, number) for path, number in sorted(cited) if number not in sections] == []


def test_the_rooms_of_the_solver_are_those_that_imports_are_checked_for():
    """In the same order: imports go down."""
    with (ROOT / "pyproject.toml").open("rb") as file:
        contracts = tomllib.load(file)["tool"]["importlinter"]["contracts"]
    (layers,) = [contract["layers"] for contract in contracts if contract.get("containers") == ["solver"]]
    page = (DOCS / "architecture.md").read_text(encoding="utf-8")
    shown = re.search(r"^\| `solver/` \|.*\n\| --- .*\n((?:\|.*\n)+)", page, flags=re.MULTILINE)
    assert re.findall(r"^\| `(\w+)`", shown[1], flags=re.MULTILINE) == layers


def test_digits_are_those_of_the_reference_file():
    with (ROOT / "tests/reference/published.yaml").open(encoding="utf-8") as file:
        gears = yaml.safe_load(file)["gears"]
    folds = table("set", "$\\Omega$", "$\\lambda_m$", "$\\lambda_a$")
    solutions = table("set", "$\\Omega$", "$\\lambda_m$", "$\\lambda_a$", "statically")
    for name, digits in gears.items():
        assert [[float(x) for x in row[1:]] for row in folds if row[0] == name] == digits["folds"]
        printed = {}
        for row in solutions:
            if row[0] == name:
                printed.setdefault(float(row[1]), []).append([float(x) for x in row[2:4]])
        assert printed == digits["solutions"]


def test_the_version_is_one():
    with (ROOT / "pyproject.toml").open("rb") as file:
        version = tomllib.load(file)["project"]["version"]
    assert yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))["version"] == version
    images = re.findall(r"bevelmap:(\d[\w.]*)", (DOCS / "how-to" / "cluster.md").read_text(encoding="utf-8"))
    assert images and set(images) == {version}


@pytest.mark.slow
def test_the_picture_of_a_row_is_drawn(tmp_path):
    """The script still runs, and draws the nine steps of the stored picture."""

    def texts(path):
        return [text for text in ElementTree.parse(path).getroot().itertext() if re.match(r"[1-9]  [A-Z]", text)]

    runpy.run_path(str(DOCS / "row_of_a_plane.py"))["draw"](tmp_path / "row.svg")
    assert texts(tmp_path / "row.svg") == texts(DOCS / "row_of_a_plane.svg")
    assert len(texts(tmp_path / "row.svg")) == 9
