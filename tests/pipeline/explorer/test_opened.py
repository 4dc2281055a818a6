"""A store that is shown: read once, and again when somebody has written into it."""

import shutil

import numpy as np
import pytest

from pipeline.errors import StoreError
from pipeline.explorer.legend import legend
from pipeline.explorer.opened import Opened
from pipeline.run.rows import sweep_block
from tests.pipeline.planes import small_plan, small_store

pytest.importorskip("panel", reason="the extra explore is not installed")

from bokeh.document import Document

from pipeline.explorer.later import Later

PLAN = small_plan("plane=omega_fe", columns=20, rows=3)


def test_what_a_sweep_adds_meanwhile_is_shown_by_the_next_page(tmp_path):
    path = small_store(tmp_path / "plane.zarr", PLAN, PLAN.blocks[:1])
    opened = Opened(path)
    first = opened.content()
    assert opened.content() is first and np.sum(first.plane.complete) == PLAN.blocks[0].stop
    before = first.layer("domains", physical=False)
    assert first.layer("domains", physical=False) is before
    for block in PLAN.blocks[1:]:
        sweep_block(str(path), PLAN, block)
    second = opened.content()
    assert second is not first and np.all(second.plane.complete)
    assert legend(before) != legend(second.layer("domains", physical=False))


def test_a_store_that_is_gone_or_a_volume_is_refused(tmp_path):
    path = small_store(tmp_path / "plane.zarr", PLAN)
    opened = Opened(path)
    opened.content()
    shutil.rmtree(path)
    with pytest.raises(StoreError, match="gone"):
        opened.content()


def test_of_each_kind_of_work_only_the_last_is_shown():
    class Page(Document):
        """Its turns are taken when the test says so."""

        def __init__(self):
            super().__init__()
            self.turns = []

        def add_next_tick_callback(self, turn):
            self.turns.append(turn)

    document, shown, failed = Page(), [], []
    later = Later(document)
    for number in range(3):
        later.ask("row", lambda number=number: number, shown.append, failed.append)
    later.ask("motions", lambda: 1 / 0, shown.append, failed.append)
    assert document.turns == [] and shown == []
    later.begin()
    while len(document.turns) < 2:  # of threads that have next to nothing to do
        pass
    for turn in document.turns:
        turn()
    assert shown == [2] and isinstance(failed[0], ZeroDivisionError)
