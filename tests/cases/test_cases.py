"""Published numbers against ours, of every case of the gallery; the page shows the same."""

import pytest
from matplotlib.figure import Figure

from bevelmap_docs import cases
from tests.cases.gallery import CASES

COMPARISONS = [
    pytest.param(
        comparison, id=f"{case.title.replace(' ', '_')}-{number}", marks=[pytest.mark.slow] if comparison.slow else []
    )
    for case in CASES
    for number, comparison in enumerate(case.comparisons)
]


@pytest.mark.parametrize("comparison", COMPARISONS)
def test_ours_are_the_published_numbers(comparison):
    ours = comparison.ours()
    differing = [
        f"{number.what}: {value} instead of {number.value} ± {number.accuracy}"
        for number, value in zip(comparison.numbers, ours, strict=True)
        if not abs(value - number.value) <= number.accuracy
    ]
    assert differing == []


def test_there_are_many_each_with_its_source():
    assert len(CASES) >= 10 and len({case.title for case in CASES}) == len(CASES)
    assert all(case.source and case.equations and case.comparisons for case in CASES)


def test_a_section_has_every_number_with_its_accuracy_and_ours():
    for case in CASES:
        found = [[number.value for number in comparison.numbers] for comparison in case.comparisons]
        text = cases.section(case, found, "")
        assert case.title in text and case.source in text and case.equations.split("$$")[1] in text
        rows = [line for line in text.splitlines() if line.startswith("| ") and "---" not in line]
        numbers = [number for comparison in case.comparisons for number in comparison.numbers]
        assert len(rows) == len(numbers) + len(case.comparisons)
        assert all(any(line.startswith(f"| {number.what} |") for line in rows) for number in numbers)


@pytest.mark.slow
@pytest.mark.parametrize("case", [case for case in CASES if case.draw], ids=lambda case: case.title)
def test_figures_are_drawn(case):
    axes = Figure().subplots()
    case.draw(axes)
    assert axes.lines or axes.images
