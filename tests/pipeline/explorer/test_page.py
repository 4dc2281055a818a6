"""The page of a plane as text: it needs nothing else, says what the store says, and is the same every time."""

import importlib.util
import json
import re
from html.parser import HTMLParser

import numpy as np
import pytest

from pipeline.__main__ import main
from pipeline.analysis.attractors.dataset import read_attractors
from pipeline.analysis.attractors.sheets import result_lines
from pipeline.plane.result import result_line
from pipeline.plane.stored import read_stored
from pipeline.store import PENDING
from tests.pipeline.explorer.planes import WORDS, integrated_store
from tests.pipeline.planes import small_plan, small_store

pytest.importorskip("bokeh", reason="the extra explore is not installed")

from pipeline.explorer.page import page_of

#: Attributes that make a browser load something.
LOADING = {"src", "href", "srcset", "data", "action", "poster", "background"}


class Elements(HTMLParser):
    """Everything that a page has: tags with their attributes, texts outside of scripts and styles."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.texts, self._stack = [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        self._stack.append(tag)

    def handle_endtag(self, tag):
        while self._stack and self._stack.pop() != tag:
            pass

    def handle_data(self, data):
        if not {"script", "style"} & set(self._stack):
            self.texts.append(data)


@pytest.fixture(scope="module")
def plane(tmp_path_factory):
    return read_stored(integrated_store(tmp_path_factory.mktemp("page")))


@pytest.fixture(scope="module")
def text(plane):
    return page_of(plane, rows=3, quantities=("dynamic_factor",), command="python -m pipeline <b>")


def content(text):
    (found,) = re.findall(r'<script type="application/json" id=plane>\n(.*?)\n</script>', text, re.DOTALL)
    return json.loads(found)


def test_nothing_is_loaded(text):
    found = Elements(text)
    for tag, attributes in found.tags:
        assert not LOADING & attributes.keys() and tag not in ("link", "iframe", "img", "object", "embed", "base"), tag
    (style,) = re.findall(r"<style>(.*?)</style>", text, re.DOTALL)
    assert "url(" not in style and "@import" not in style
    policies = [one["content"] for tag, one in found.tags if one.get("http-equiv") == "Content-Security-Policy"]
    (policy,) = (dict(part.strip().split(" ", 1) for part in one.split(";")) for one in policies)
    assert policy["default-src"] == "'none'" and not any("http" in allowed for allowed in policy.values())
    assert "sourceMappingURL" not in text
    assert not re.search(r"https?://", json.dumps(content(text)))


def test_it_says_what_the_map_tells_and_where_it_is_wrong(plane, text):
    said = " ".join(" ".join(Elements(text).texts).split()).lower()
    assert result_line(plane).lower() in said
    for line in result_lines(plane.path, plane.plan, read_attractors(plane.path)):
        assert line.lower().rstrip(".") in said
    assert "python -m pipeline <b>" in said and plane.about["configuration_hash"] in said


@pytest.mark.costly
def test_layers_and_rows_are_those_that_were_asked_for(plane, text):
    data = content(text)
    assert data["layers"] == ["domains", "dynamic", "attractors", "credibility", "dynamic_factor"]
    assert len(data["rows"]) == len(data["ends"]) == 3 and set(data["rows"]) <= set(plane.rows.tolist())
    buttons = [one for tag, one in Elements(text).tags if tag == "button"]
    assert [one["data-layer"] for one in buttons if "data-layer" in one] == data["layers"]
    assert len([one for one in buttons if "data-row" in one]) == 3
    bare = page_of(plane, rows=0, quantities=())
    assert content(bare)["rows"] == [] and "id=curves" not in bare and len(content(bare)["document"]["roots"]) == 1


@pytest.mark.costly
def test_the_same_store_gives_the_same_text(plane, text):
    # Bokeh has counted on in between.
    again = page_of(read_stored(plane.path), rows=3, quantities=("dynamic_factor",), command="python -m pipeline <b>")
    assert again == text


def words(path, *further):
    return [
        *WORDS,
        "stages=[page]",
        "cluster=none",
        "cluster.address=tcp://10.0.0.7:8786",
        "store.name=plane",
        f"store.root={path.parent}",
        f"output.root={path.parent}/outputs",
        "page.rows=2",
        "page.quantities=[]",
        *further,
    ]


@pytest.mark.costly
def test_the_stage_writes_one_file_and_makes_it_anew_only_if_something_changed(plane, tmp_path, capsys):
    path = integrated_store(tmp_path)
    made = tmp_path / "outputs/page/plane.html"
    assert main(words(path)) == 0
    said, first, stat = capsys.readouterr().out, made.read_bytes(), made.stat()
    assert "plane.html" in said and "up to date" not in said and len(first) < 5e6
    command = re.search(r"Made by <code>(.*?)</code>", first.decode())[1]
    assert "plane.sweep.min=1.0" in command and "store.name=plane" in command and "stages=[page]" in command
    # Where it was made is nothing to who gets it.
    assert "cluster" not in command and not any(one in first.decode() for one in (str(tmp_path), "10.0.0.7"))
    assert main(words(path)) == 0
    assert "up to date" in capsys.readouterr().out and made.stat().st_mtime_ns == stat.st_mtime_ns
    assert main(words(path, "page.rows=1")) == 0
    assert "up to date" not in capsys.readouterr().out and len(content(made.read_text())["rows"]) == 1
    made.write_bytes(first[:-100])
    assert main(words(path)) == 0 and made.read_bytes() == first
    assert sorted(one.name for one in made.parent.iterdir()) == [".plane.json", "plane.html"]


@pytest.mark.parametrize(
    ("further", "named"),
    [
        (["figures.units=physical"], "figures.units = 'physical'"),
        (["page.rows=-1"], "page.rows = -1"),
        (["page.quantities=[speed]"], "page.quantities = 'speed'"),
    ],
)
def test_what_cannot_be_is_refused_before_anything_is_written(plane, capsys, tmp_path, further, named):
    assert main(words(plane.path, f"output.root={tmp_path}/o", *further)) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert named in line and not (tmp_path / "o").exists()


def test_without_bokeh_one_line_says_what_to_install(plane, capsys, tmp_path, monkeypatch):
    found = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name, *rest: None if name == "bokeh" else found(name, *rest)
    )
    assert main(words(plane.path, f"output.root={tmp_path}/o")) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "bokeh" in line and "pip install 'bevelmap[explore]'" in line and not (tmp_path / "o").exists()


@pytest.mark.costly
def test_an_unfinished_plane_says_so(tmp_path):
    plane = read_stored(small_store(tmp_path / "plane.zarr", small_plan(columns=20, rows=6)))
    vars(plane)["status"] = np.where(np.arange(6) < 2, plane.status, PENDING)
    said = " ".join(Elements(page_of(plane, rows=1, quantities=())).texts)
    assert "4 of 6 rows are not computed" in said and "Nothing was integrated" in said
