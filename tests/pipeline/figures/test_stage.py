"""The stage: figures drawn side by side are those drawn one after the other, and one that fails is no success."""

import dataclasses
import io

import pytest

from pipeline.config.compose import compose
from pipeline.figures.stage import STAGE
from pipeline.run.job import Job
from pipeline.run.progress import Reporter
from tests.pipeline.planes import small_plan, small_store


class SideBySide:
    """Workers that end in another order, or fail."""

    has_local_workers = True

    def __init__(self, error: Exception | None = None):
        self.error = error

    def run_beside(self, function, tasks):
        for task in reversed(list(tasks)):
            yield task, self.error or function(*task)


class Alone:
    has_local_workers = False


@pytest.fixture(scope="module")
def job(tmp_path_factory):
    folder = tmp_path_factory.mktemp("stage")
    settings = compose(
        [
            f"store.root={folder}",
            f"output.root={folder}",
            "store.name=plane",
            "figures.formats=[png]",
            "figures.dpi=30",
            "figures.curves=[0.25]",
        ]
    )
    plan = small_plan(columns=9, rows=3)
    small_store(settings.store_path, plan)
    return Job(settings, plan)


def drawn(job, workforce, folder):
    """Status, what was said, and files by name, without those of a record."""
    config = dataclasses.replace(
        job.settings.config, output=dataclasses.replace(job.settings.config.output, root=str(folder))
    )
    said = io.StringIO()
    job = dataclasses.replace(job, settings=dataclasses.replace(job.settings, config=config))
    status = STAGE.run(job, workforce, Reporter(said))
    return status, said.getvalue(), {file.name: file.read_bytes() for file in (folder / "figures/plane").glob("[!.]*")}


@pytest.mark.costly
def test_side_by_side_they_are_the_same(job, tmp_path):
    (status, said, one), (_, other, many) = (
        drawn(job, workforce, tmp_path / name) for name, workforce in (("one", Alone()), ("many", SideBySide()))
    )
    assert status == 0 and one == many and set(one) == {"map.png", "curves.png", "backbone.png"}
    assert said.split(" in ")[0] == other.split(" in ")[0].replace("many", "one")


@pytest.mark.costly
def test_drawn_once_they_are_kept(job, tmp_path):
    _, _, first = drawn(job, Alone(), tmp_path)
    _, said, again = drawn(job, SideBySide(ValueError("drawn again")), tmp_path)
    assert "up to date" in said and first == again
    (tmp_path / "figures/plane/map.png").write_bytes(b"edited")
    _, said, again = drawn(job, Alone(), tmp_path)
    assert "up to date" not in said and first == again


def test_one_that_fails_is_no_success(job, tmp_path):
    with pytest.raises(ValueError, match="no room"):
        drawn(job, SideBySide(ValueError("no room")), tmp_path)
