"""The page in a real browser: what a reader does, at two sizes of the window, and nothing in the console."""

import json
import time
from pathlib import Path
from urllib.parse import parse_qsl, urlsplit

import pytest

from pipeline.store import read_plan

#: Milliseconds that a page may take, however busy the machine is.
PATIENCE = 60_000
SIZES = {"wide": (1440, 900), "narrow": (1000, 760)}


#: Where in the window a place of a figure is.
_PIXELS = """([name, x, y]) => {
  const model = Bokeh.documents[0].get_model_by_name(name), view = Bokeh.index.find_one(model);
  view.el.scrollIntoView({block: "center"});
  const box = view.el.getBoundingClientRect(), {bbox, x_scale, y_scale} = view.frame;
  return [box.left + x_scale.compute(x), box.top + y_scale.compute(y)];
}"""


class Reader:
    """Somebody at a page."""

    def __init__(self, window, size: str):
        width, height = SIZES[size]
        self.page = window.new_page()
        self.page.set_viewport_size({"width": width, "height": height})
        self.page.set_default_timeout(PATIENCE)
        self.said, self.asked = [], []
        self.page.on("console", lambda one: self.said.append(one.text) if one.type in ("error", "warning") else None)
        self.page.on("pageerror", lambda error: self.said.append(str(error)))
        self.page.on("request", lambda request: self.asked.append(request.url))

    def open(self, url: str) -> None:
        self.page.goto(url)
        self.page.wait_for_selector(".map canvas")

    @property
    def view(self) -> dict[str, str]:
        """What the address says."""
        return dict(parse_qsl(urlsplit(self.page.url).query))

    def until(self, done) -> None:
        """Wait for what the page does in its own time."""
        end = time.monotonic() + PATIENCE / 1000
        while not done():
            assert time.monotonic() < end, self.page.url
            self.page.wait_for_timeout(50)

    def click_map(self, across: float, up: float) -> None:
        """Click a place of the map, in shares of the figure."""
        box = self.page.locator(".map canvas").first.bounding_box()
        before = self.view.get("at")
        self.page.mouse.click(box["x"] + across * box["width"], box["y"] + up * box["height"])
        self.until(lambda: self.view.get("at") != before)
        self.page.wait_for_selector(".place-here canvas")
        self.integrated()

    def heading(self, column: str) -> str:
        """Of a place."""
        return self.page.locator(f".place-{column} h2").inner_text()

    def integrated(self) -> None:
        """Wait for what integration says of the place."""
        self.page.locator(".place-here").get_by_text("Integration finds").wait_for()

    def state(self) -> list[float]:
        """The initial state of the view."""
        return list(map(float, self.view["start"].split(",")))

    def figures(self) -> dict[str, str]:
        """Name -> identifier of every figure of the page."""
        models = "[...Bokeh.documents[0]._all_models.values()].filter(one => one.type === 'Figure')"
        return dict(self.page.evaluate(f"{models}.map(one => [one.name, one.id])"))

    def drag(self, name: str, start: tuple[float, float], end: tuple[float, float]) -> None:
        """Drag from one place of a figure to another, both in the units of its axes."""
        places = [self.page.evaluate(_PIXELS, [name, *place]) for place in (start, end)]
        mouse = self.page.mouse
        mouse.move(*places[0])
        mouse.down()
        mouse.move(*(0.5 * (a + b) for a, b in zip(*places, strict=True)))
        mouse.move(*places[1])
        mouse.up()


@pytest.fixture
def reader(window, served):
    readers = []

    def sit_down(size: str = "wide") -> Reader:
        readers.append(Reader(window, size))
        return readers[-1]

    yield sit_down
    for one in readers:
        assert one.said == []
        outside = [url for url in one.asked if not url.startswith((served.url, "data:", "blob:"))]
        # Everything comes from this machine.
        assert [url for url in outside if not url.startswith(served.url.replace("http", "ws"))] == []
        one.page.close()


@pytest.mark.costly
def test_a_place_is_clicked_pinned_and_linked(reader, served):
    one = reader()
    one.open(served.url)
    assert one.view == {} and not one.page.locator(".place-here").is_visible()
    one.click_map(0.35, 0.5)
    first, figures = one.heading("here"), one.figures()
    x, p = map(float, one.view["at"].split(","))
    assert 0.05 <= x <= 2.0 and 0.0 <= p <= 0.5 and f"Ω = {x:.4g}" in first
    one.click_map(0.7, 0.3)
    # Another place is shown by the same figures.
    assert one.heading("here") != first and one.figures() == figures
    assert {"map", "curves", "time", "force", "phase", "spectrum"} <= set(figures)
    one.page.get_by_role("button", name="Pin", exact=True).click()
    one.until(lambda: one.view.get("pin") == one.view["at"])
    second = one.heading("here")
    one.click_map(0.35, 0.5)
    one.page.wait_for_selector(".place-pinned canvas")
    assert one.heading("pinned") == second != one.heading("here")
    # A link reproduces the view, and nothing of it is cut off at the side of a smaller window.
    other = reader("narrow")
    other.open(one.page.url)
    other.page.wait_for_selector(".place-pinned canvas")
    assert (other.heading("here"), other.heading("pinned")) == (one.heading("here"), one.heading("pinned"))
    assert other.view == one.view
    for page in (one.page, other.page):
        assert page.evaluate("document.documentElement.scrollWidth <= window.innerWidth")


@pytest.mark.costly
def test_zoom_layers_and_the_reset_of_both_are_in_the_address(reader, served):
    one = reader()
    one.open(served.url)
    box = one.page.locator(".map canvas").first.bounding_box()
    one.page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
    one.page.mouse.wheel(0, -400)
    one.until(lambda: "window" in one.view)
    low, high, *_ = map(float, one.view["window"].split(","))
    assert 0.0 < high - low < 1.95
    one.page.get_by_label("Map shows").select_option(label="n/I, dynamically stable motions")
    one.until(lambda: one.view.get("layer") == "dynamic")
    one.page.get_by_label("Map shows").select_option(label="share of the period without contact")
    one.until(lambda: one.view.get("layer") == "contact_loss")
    one.page.go_back()
    one.until(lambda: one.view.get("layer") == "dynamic")


@pytest.mark.costly
def test_a_motion_is_integrated_from_any_state_and_from_one_that_is_dragged(reader, served):
    one = reader()
    one.open(f"{served.url}?at=0.6,0.2")
    one.integrated()
    chosen = one.page.get_by_label("In time, integrated")
    chosen.select_option(label="from motion 2 of the map")
    one.page.get_by_text("From motion 2 of the map, λ").wait_for()
    assert one.view["motion"] == "2"
    chosen.select_option(label="from a state of one's own")
    one.until(lambda: "start" in one.view)
    one.page.locator(".place-here").get_by_text("From λ = ").wait_for()
    x, speed = one.state()
    one.until(lambda: "state-plane" in one.figures())
    one.drag("state-plane", (x, speed), (x + 0.02, speed - 0.01))
    one.until(lambda: one.state() == pytest.approx([x + 0.02, speed - 0.01], abs=2e-3))
    there = one.state()
    one.page.get_by_text(f"From λ = {there[0]:.4g}, λ' = {there[1]:.4g}").wait_for()
    one.page.get_by_role("button", name="Basins").click()
    one.until(lambda: one.view.get("basins") == "1")
    one.page.locator(".place-here").get_by_text("of the slice").first.wait_for()


@pytest.mark.costly
def test_a_design_point_and_its_tolerances_are_dragged_and_have_margins(reader, served):
    one = reader()
    one.open(served.url)
    one.page.get_by_role("checkbox").check()
    one.until(lambda: "design" in one.view)
    one.page.get_by_text("distance", exact=True).wait_for()
    one.page.get_by_label("± Ω").fill("0.1")
    one.page.keyboard.press("Enter")
    one.until(lambda: one.view.get("tolerances", "").startswith("0.1,"))
    one.page.get_by_text("Within the tolerances").wait_for()
    x, p = map(float, one.view["design"].split(","))
    # The right edge by 0.2: the point by half of it, and the tolerance as well.
    one.drag("map", (x + 0.1, p), (x + 0.3, p))
    one.until(lambda: float(one.view["tolerances"].split(",")[0]) == pytest.approx(0.2, abs=0.02))
    one.until(lambda: float(one.view["design"].split(",")[0]) == pytest.approx(x + 0.1, abs=0.02))
    one.page.locator(".controls").get_by_text(f"Ω = {float(one.view['design'].split(',')[0]):.4g}").wait_for()


@pytest.mark.costly
def test_a_changed_gear_has_its_row_at_once_and_its_plane_is_computed(reader, served):
    one = reader()
    one.open(f"{served.url}?at=0.6,0.2")
    one.integrated()
    compute = one.page.get_by_role("button", name="Compute this plane")
    assert compute.is_disabled()
    slider = one.page.locator(".noUi-handle").first
    slider.focus()
    one.page.keyboard.press("ArrowLeft")
    one.until(lambda: "b" in one.view)
    b = float(one.view["b"])
    assert b < 1.0
    one.page.get_by_text("The map is of the stored plane").wait_for()
    compute.click()
    link = one.page.get_by_role("link", name="show it")
    link.wait_for()
    with one.page.expect_popup() as opened:
        link.click()
    opened.value.wait_for_selector(".map canvas", timeout=PATIENCE)
    assert opened.value.locator("h1").inner_text() == f"omega_fe-b={b!r}"
    opened.value.close()
    assert read_plan(served.store.with_name(f"omega_fe-b={b!r}.zarr")).gear["b"] == b
    one.page.get_by_role("button", name="Reset").click()
    one.until(lambda: "b" not in one.view)


@pytest.mark.costly
def test_figures_and_numbers_are_saved(reader, served, tmp_path):
    one = reader()
    one.open(f"{served.url}?at=0.6,0.2")
    one.integrated()
    one.page.get_by_text("Save and repeat").click()

    def saved() -> Path:
        with one.page.expect_download() as waiting:
            one.page.get_by_text("Save", exact=True).click()
        path = tmp_path / waiting.value.suggested_filename
        waiting.value.save_as(path)
        return path

    picture = saved()
    assert picture.name == "omega_fe-map.png" and picture.read_bytes().startswith(b"\x89PNG")
    selects = one.page.locator(".controls select")
    selects.nth(1).select_option(label="motions at the place")
    selects.nth(2).select_option(label="json")
    numbers = saved()
    assert numbers.suffix == ".json" and len(json.loads(numbers.read_text())["data_vars"]["amplitude"]["data"]) == 3
    assert "plane.motions_at(omega=0.6, f_e=0.2)" in one.page.locator("pre").first.inner_text()
    # Where there is nothing to be saved, the file and the page say why.
    selects.nth(1).select_option(label="map")
    selects.nth(2).select_option(label="png")
    away = served.store.with_name("away.zarr")
    served.store.rename(away)
    try:
        assert "is gone" in saved().read_text()
    finally:
        away.rename(served.store)
    one.page.locator(".map").get_by_text("is gone").wait_for()
