"""Tasks in threads: results in their order, errors in their turn, nothing begun that nobody wants."""

import os
import threading

import pytest

from solver.kernels.threads import side_by_side


@pytest.fixture(params=[1, 2, 64])
def processors(request, monkeypatch):
    monkeypatch.setattr(os, "cpu_count", lambda: request.param)
    return request.param


def test_results_come_in_the_order_of_the_tasks(processors):
    assert list(side_by_side(lambda x: x * x, range(50))) == [x * x for x in range(50)]
    assert list(side_by_side(str, [])) == []
    assert list(side_by_side(str, iter([3]))) == ["3"]


def test_threads_are_used_where_there_are_processors(processors):
    both = threading.Barrier(min(processors, 2))
    threads = set(side_by_side(lambda _: (both.wait(20.0), threading.get_ident())[1], range(2)))
    assert len(threads) == min(processors, 2)


def test_an_error_is_raised_in_its_turn(processors):
    results = side_by_side(lambda x: 1 / x, [2, 1, 0, 4])
    assert [next(results), next(results)] == [0.5, 1.0]
    with pytest.raises(ZeroDivisionError):
        next(results)


def test_whoever_stops_asking_does_not_wait_for_what_has_not_begun(processors):
    begun, go_on = [], threading.Event()

    def task(x):
        begun.append(x)
        return x and go_on.wait(0.1)

    results = side_by_side(task, range(1000))
    next(results)
    results.close()
    assert len(begun) < 1000
