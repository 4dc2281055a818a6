"""The page of a plane in a real browser, as wide as a screen and as narrow as a telephone."""

import numpy as np
import pytest

from pipeline.analysis.attractors.dataset import read_attractors
from pipeline.plane.division import stored_division
from pipeline.plane.row_curves import stored_row
from pipeline.plane.stored import read_stored
from solver import domain_label
from solver.regions.labelling import static_code
from tests.pipeline.explorer.planes import integrated_store

pytest.importorskip("bokeh", reason="the extra explore is not installed")

from pipeline.explorer.page import page_of

SIZES = {"screen": dict(width=1280, height=900), "telephone": dict(width=390, height=800)}
MAP, CURVES = "Bokeh.documents[0].roots()[0]", "Bokeh.documents[0].roots()[1]"
VIEW = f"Bokeh.index.get_one({MAP})"


@pytest.fixture(scope="module")
def plane(tmp_path_factory):
    return read_stored(integrated_store(tmp_path_factory.mktemp("browser")))


@pytest.fixture(scope="module")
def file(plane, tmp_path_factory):
    path = tmp_path_factory.mktemp("browser") / "plane.html"
    path.write_text(page_of(plane, rows=4), encoding="utf-8")
    return path


@pytest.fixture(scope="module", params=SIZES)
def page(request, browser, file):
    """The page, drawn, as the tests before have left it; what the browser complained of and what it asked for are
    looked at in the end."""
    touch = request.param == "telephone"
    context = browser.new_context(viewport=SIZES[request.param], has_touch=touch)
    opened, complaints, requests = context.new_page(), [], []
    opened.on("console", lambda said: said.type in ("error", "warning") and complaints.append(said.text))
    opened.on("pageerror", lambda error: complaints.append(str(error)))
    opened.on("request", lambda asked: requests.append(asked.url))
    opened.goto(file.as_uri())
    opened.wait_for_selector("body[data-ready]")
    opened.touch = touch
    yield opened
    assert complaints == [] and requests == [file.as_uri()]
    context.close()


def clicked(page, x, p):
    """Click a place of the map, tap it on a telephone; what is told then."""
    page.wait_for_function(f"{VIEW}.frame.bbox.width > 50")
    page.locator("#map").scroll_into_view_if_needed()
    found = page.evaluate(
        f"""([x, p]) => {{
            const box = document.getElementById("map").getBoundingClientRect(), frame = {VIEW}.frame;
            return [box.left + frame.x_scale.compute(x), box.top + frame.y_scale.compute(p)];
        }}""",
        [x, p],
    )
    before = page.locator("#told").inner_text()
    (page.touchscreen.tap if page.touch else page.mouse.click)(*found)
    page.wait_for_function("before => document.getElementById('told').innerText !== before", arg=before)
    return page.locator("#told").inner_text()


def test_a_click_tells_the_exact_label_and_what_integration_found(page, plane):
    found, division = read_attractors(plane.path), stored_division(plane)
    for x, p in ((1.0531, 0.2), (1.182, 0.3017), (1.32, 0.2871)):
        told = clicked(page, x, p)
        # A pixel off, at most; these places are not so near to a boundary.
        code = int(static_code(division.codes_at(np.array([x]), np.array([p])))[0, 0])
        assert f"n/I {domain_label(code)};" in told, (x, p)
        near = {"omega": x, "f_e": p}
        cell = found.sel(near, method="nearest")
        label = found.label.attrs["labels"][int(cell.label)]
        assert f"integration {label};" in told and "verdict" in told


@pytest.mark.costly
def test_layers_change_and_tell_their_values(page, plane):
    clicked(page, 1.0531, 0.3)
    for name, word in (("dynamic_factor", "dynamic factor"), ("attractors", "integration"), ("domains", "n/I")):
        page.locator(f"#layers [data-layer={name}]").click()
        shown = page.evaluate(f"[...new Set({MAP}.renderers.filter(one => one.visible).flatMap(one => one.tags))]")
        assert shown == [name]
        assert page.locator(".aside[data-layer]:visible").count() == 1
        assert page.locator("#layers [aria-pressed=true]").get_attribute("data-layer") == name
        told = clicked(page, 1.12, {"attractors": 0.201, "dynamic_factor": 0.2, "domains": 0.202}[name])
        assert word in told
        if name == "dynamic_factor":
            row = int(np.argmin(np.abs(plane.rows - 0.2)))
            column = int(np.argmin(np.abs(plane.plan.sweep.values - 1.12)))
            value = float(told.split("dynamic factor ")[1].split(";")[0])
            assert value == pytest.approx(plane.extreme("dynamic_factor", "worst")[row, column], rel=2e-2)
    picture = page.locator("#map").screenshot()
    page.locator("#layers [data-layer=credibility]").click()
    page.wait_for_timeout(300)
    assert page.locator("#map").screenshot() != picture


def test_curves_are_those_of_the_row_next_to_a_click(page, plane):
    clicked(page, 1.0531, 0.35)
    row = int(page.locator("#rows [aria-pressed=true]").get_attribute("data-row"))
    values = page.evaluate("JSON.parse(document.getElementById('plane').textContent).rows")
    assert row == int(np.argmin(np.abs(np.array(values) - 0.35)))
    drawn = f"{CURVES}.renderers.find(one => one.visible && one.name === 'branches')"
    assert page.evaluate(f"{drawn}.tags") == [row]
    points = page.evaluate(
        f"Array.from({drawn}.data_source.data.xs, line => Array.from(line)).flat().filter(Number.isFinite).length"
    )
    number = int(np.argmin(np.abs(plane.rows - values[row])))
    assert points == sum(segment.stop - segment.start for segment in stored_row(plane, number).segments)
    assert page.evaluate(f"{MAP}.center.find(one => one.name === 'row').location") == values[row]
    page.locator("#rows [data-row='0']").click()
    assert page.evaluate(f"{drawn}.tags") == [0]


def test_hovering_shows_a_tooltip_and_the_wheel_zooms(page):
    if page.touch:
        pytest.skip("a telephone has neither")
    box = page.locator("#map").bounding_box()
    page.mouse.move(box["x"] + 0.3 * box["width"], box["y"] + 0.5 * box["height"])
    page.wait_for_selector(".bk-Tooltip:visible")
    # Its text is in a tree of its own.
    assert "n/I" in page.locator(".bk-Tooltip:visible").first.evaluate("found => found.shadowRoot.textContent")
    before = page.evaluate(f"{MAP}.x_range.end - {MAP}.x_range.start")
    page.mouse.wheel(0, -300)
    page.wait_for_function(f"{MAP}.x_range.end - {MAP}.x_range.start < {before}")


def test_nothing_is_wider_than_the_window(page):
    assert page.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
