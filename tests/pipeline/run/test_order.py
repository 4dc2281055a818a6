"""In which order stages run, begin beside others, and finish."""

import pytest

from pipeline.run.preparation import _run
from pipeline.run.progress import Reporter
from pipeline.run.stage import Stage


@pytest.fixture
def done():
    return []


def made(name: str, done: list, status: int = 0, **options) -> Stage:
    def run(job, workforce, reporter) -> int:
        done.append(f"run {name}")
        return status

    return Stage(
        name,
        run,
        begin=lambda job, workforce: done.append(f"begin {name}"),
        finish=lambda job, reporter: done.append(f"finish {name}"),
        **options,
    )


def test_a_stage_begins_when_no_other_will_write_what_it_reads(done):
    stages = [made("first", done, writes=True), made("second", done, writes=True), made("reads", done)]
    assert _run([*stages, made("too", done, status=1)], None, None, Reporter()) == 1
    assert done == [
        *("run first", "begin second", "finish first"),
        *("run second", "begin reads", "begin too", "finish second"),
        *("run reads", "begin too", "finish reads"),
        *("run too", "finish too"),
    ]
