"""docs/failure-modes.md names a test on every line, and no test that is not there."""

import re
from pathlib import Path

HERE = Path(__file__).parent
PAGE = HERE.parents[2] / "docs/failure-modes.md"


def test_every_line_of_the_page_has_a_test_and_every_test_of_faults_a_line():
    lines = [line for line in PAGE.read_text(encoding="utf-8").splitlines() if line.startswith("| ")][2:]
    named = [re.findall(r"`(test_\w+\.py)::(test_\w+)`", line.split(" | ")[-1]) for line in lines]
    assert len(lines) > 20 and all(named)
    tests = {
        (file, test)
        for file in HERE.parents[1].rglob("test_*.py")
        for test in re.findall(r"^def (test_\w+)\(", file.read_text(encoding="utf-8"), re.MULTILINE)
    }
    faults = {(file.name, test) for file, test in tests if file.parent == HERE and file.name != "test_page.py"}
    named = {test for tests in named for test in tests}
    assert faults <= named <= {(file.name, test) for file, test in tests}
