"""The reference is made from the program: every key, stage and public name is in it, and pages load nothing else."""

import importlib
import re

import pytest
import yaml

from bevelmap_docs import commands, configuration, names
from pipeline.stages import STAGES
from tests.docs.page import DOCS, ROOT

MARK = re.compile(r"^<!-- generated: (\w+)((?: [\w.]+)*) -->$", re.MULTILINE)
ASKED = [
    (mark[1], tuple(mark[2].split()))
    for page in sorted(DOCS.rglob("*.md"))
    if "_build" not in page.parts
    for mark in MARK.finditer(page.read_text(encoding="utf-8"))
]


def asked(generator):
    return {arguments[0] if arguments else "" for name, arguments in ASKED if name == generator}


def test_every_part_of_the_configuration_has_its_table():
    assert asked("keys") == set(configuration.PARTS)
    assert asked("choices") == {folder.name for folder in (ROOT / "conf").iterdir() if folder.is_dir()}


def test_every_key_of_the_schema_is_in_a_table():
    shown = {key.name for part in configuration.PARTS for key in configuration.documented(part)}
    known = configuration.types_of_keys()
    parts = {part.partition(".")[0] for part in configuration.PARTS}
    # The third axis has the keys of the other two.
    assert known.keys() - shown - parts == {f"plane.parameter2.{name}" for name in ("name", "min", "max", "num")}


def test_every_key_has_a_comment_of_its_own():
    lacking = [
        key.name
        for part in configuration.PARTS
        for key in configuration.documented(part)
        if not key.meaning and key.name != part
    ]
    assert lacking in ([], ["plane.sweep", "plane.parameter"])


def test_defaults_are_those_of_the_files():
    (found,) = [key for key in configuration.documented("gear") if key.name == "gear.translation_coupling"]
    gear = yaml.safe_load((ROOT / "conf/gear/published.yaml").read_text(encoding="utf-8"))
    assert float(found.default) == gear["translation_coupling"] and "geometric" in found.meaning
    (found,) = [key for key in configuration.documented("store") if key.name == "store.root"]
    assert found.default == "${output.root}/store" and found.type == "text"


def test_a_choice_is_named_with_its_comment_and_the_default_is_marked():
    table = configuration.choices("solver")
    assert re.search(r"\| `first_order` \(default\) \| .*order 1", table) and "| `hb` |" in table


def test_every_stage_is_in_the_table_in_the_order_of_a_run():
    assert re.findall(r"^\| `(\w+)` \|", commands.stages(), flags=re.MULTILINE) == [entry.name for entry in STAGES]


@pytest.mark.parametrize(
    "package", ["pipeline", "solver", "solver.boundaries", "solver.regions", "solver.stability", "solver.timedomain"]
)
def test_every_public_name_is_on_a_page(package):
    listed = importlib.import_module(package).__all__
    assert package in asked("names") and set(names.public(package)) == set(listed)
    text = names.names(package)
    assert all(re.search(rf"^\.\. auto\w+:: [\w.]+\.{name}$", text, flags=re.MULTILINE) for name in listed)


def test_what_a_browser_would_fetch_is_found():
    offline = pytest.importorskip("bevelmap_docs.offline", reason="Sphinx is installed by `make docs`")
    assert offline.fetched('<script src="_static/a.js"></script><a href="https://a.org">a</a>') == []
    for text in (
        '<script defer src="https://cdn.org/a.js">',
        "<link rel=stylesheet href='//cdn.org/a.css'>",
        '<img alt="" src=http://a.org/a.png>',
        "@font-face { src: url(https://a.org/a.woff2) }",
        '@import "https://a.org/a.css";',
    ):
        assert len(offline.fetched(text)) == 1, text


@pytest.mark.slow
def test_every_group_of_a_store_has_its_table():
    from bevelmap_docs import store

    assert asked("arrays") == {"", *store.groups()}
    needs = {array.name: array.needs for array in store.stored()}
    assert needs["motion"] == needs["branches/motion"] == "solver=hb"
    assert needs["certified"] == "solver=first_order" and needs["amplitude"] == needs["boundaries/kind"] == ""
