"""What an entry of the kernel cache is named after: whatever changes a kernel, and nothing else."""

import importlib
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from solver.kernels import types
from solver.kernels.compile import kernel

ROOT = Path(__file__).parents[3]

#: A package whose kernel `top` uses everything that a kernel may use, by every kind of import.
TEXTS = {
    "__init__.py": "",
    "user.py": '''
import math
import numpy as np
from solver.kernels import types
from solver.kernels.compile import kernel
from {name} import constants
from {name}.deep import passed_on
from {name}.deep.inner import (
    below,  # with a comment
    FACTOR as factor,
)
from {name}.constants import *
from {name}.stranger import unused

TABLE = np.array([1.0, 2.0, 3.0])
FIRST, SECOND = range(2)

@kernel(types.float64(types.float64), inner=True)
def beside(x):
    return x + TABLE[FIRST]

@kernel(types.float64(types.float64))
def top(x):
    """Its documentation."""
    total = below(x) + factor * beside(x) + passed_on(x)
    for i in range(3):
        total += TABLE[i] * STARRED
    return math.sqrt(total) + np.float64(1.5)

@kernel(types.float64(types.float64))
def other(x):
    return 2.0 * x
''',
    "constants.py": "STARRED = 4.0\n",
    "deep/__init__.py": "from {name}.deep.inner import passed_on\n",
    "deep/inner.py": """
from solver.kernels import types
from solver.kernels.compile import kernel

FACTOR = 3.0

@kernel(types.float64(types.float64), inline=True)
def lowest(x):
    return x - 1.0

@kernel(types.float64(types.float64), inner=True)
def below(x):
    return lowest(x) * x

@kernel(types.float64(types.float64), inner=True)
def passed_on(x):
    return x / 7.0
""",
    "stranger.py": "unused = 5.0\n",
}

CHANGES = {
    "a number in its code": ("user.py", "np.float64(1.5)", "np.float64(1.25)"),
    "an operation in its code": ("user.py", "factor * beside(x)", "factor / beside(x)"),
    "a name in its code": ("user.py", "math.sqrt(total)", "math.cbrt(total)"),
    "its signature": (
        "user.py",
        "@kernel(types.float64(types.float64))\ndef top",
        "@kernel(types.float64(types.float32))\ndef top",
    ),
    "an array": ("user.py", "[1.0, 2.0, 3.0]", "[1.0, 2.0, 3.5]"),
    "the type of an array": ("user.py", "[1.0, 2.0, 3.0])", "[1.0, 2.0, 3.0], np.float32)"),
    "a number that a kernel of the same file uses": ("user.py", "range(2)", "range(1, 3)"),
    "a number from a parenthesised import": ("deep/inner.py", "FACTOR = 3.0", "FACTOR = 3.5"),
    "a kernel from a parenthesised import": ("deep/inner.py", "lowest(x) * x", "lowest(x) / x"),
    "a kernel two calls away": ("deep/inner.py", "x - 1.0", "x - 2.0"),
    "whether a kernel two calls away is inlined": ("deep/inner.py", "inline=True", "inner=True"),
    "a kernel that a package passes on": ("deep/inner.py", "x / 7.0", "x / 8.0"),
    "a number from a star import": ("constants.py", "4.0", "4.5"),
    "the type of a number": ("constants.py", "4.0", "4"),
}
NOTHINGS = {
    "a comment": ("user.py", "    total = below", "    # A comment.\n    total = below"),
    "its documentation": ("user.py", "Its documentation.", "Other words."),
    "lines above it": ("user.py", "TABLE =", "\n\n\nTABLE ="),
    "another kernel of the file": ("user.py", "2.0 * x", "3.0 * x"),
    "a number that it does not use": ("stranger.py", "5.0", "6.0"),
    "the way of an import": ("user.py", "from {name}.constants import *", "STARRED = constants.STARRED"),
    "another number beside it": ("deep/inner.py", "FACTOR = 3.0\n", "UNUSED = 1\nFACTOR = 3.0\n"),
}


@pytest.fixture
def package(tmp_path, monkeypatch):
    """Write the package, with a change, and import its kernel."""
    monkeypatch.syspath_prepend(str(tmp_path))

    def write(change=None, name="kernels_of_a_test"):
        for file, text in TEXTS.items():
            if change is not None and change[0] == file:
                assert change[1] in text
                text = text.replace(change[1], change[2])
            path = tmp_path / name / file
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text.replace("{name}", name))
        for module in [module for module in sys.modules if module.split(".")[0] == name]:
            del sys.modules[module]
        shutil.rmtree(tmp_path / name / "__pycache__", ignore_errors=True)
        shutil.rmtree(tmp_path / name / "deep/__pycache__", ignore_errors=True)
        importlib.invalidate_caches()
        return importlib.import_module(f"{name}.user")

    return write


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
def test_what_changes_a_kernel_changes_its_entry(package, change):
    before = package().top.content
    changed = package(change)
    assert changed.top.content != before and changed.other.content == package().other.content
    assert package().top.content == before


@pytest.mark.parametrize("change", NOTHINGS.values(), ids=NOTHINGS)
def test_what_changes_nothing_keeps_the_entry(package, change):
    assert package(change).top.content == package().top.content


def test_a_renamed_file_has_entries_of_its_own(package):
    """Compiled code names the module that it belongs to."""
    assert package().top.content != package(name="renamed_kernels").top.content


LIST = [1.0, 2.0]


def test_what_may_change_is_refused():
    @kernel(types.float64(types.float64))
    def takes_a_list(x):
        return x * LIST[0]

    with pytest.raises(TypeError, match=r"takes_a_list.*\[1.0, 2.0\]"):
        takes_a_list(1.0)

    settings = {"factor": 2.0}

    @kernel(types.float64(types.float64))
    def takes_a_dictionary(x):
        return x * settings["factor"]

    with pytest.raises(TypeError, match="takes_a_dictionary.*factor"):
        takes_a_dictionary(1.0)


def test_values_of_closures_belong_to_it():
    def multiplier(factor):
        @kernel(types.float64(types.float64))
        def multiply(x):
            return factor * x

        return multiply

    twice, again, thrice = multiplier(2.0), multiplier(2.0), multiplier(3.0)
    assert twice.content == again.content != thrice.content
    assert multiplier(np.nan).content != multiplier(0.0).content != multiplier(-0.0).content


SCRIPT = """
import json, sys
sys.path[:0] = [sys.argv[1], {root!r}]
from solver.kernels import backend
names, compiled = [], backend._compiled
backend._compiled = lambda kernel, *others: names.append(kernel.__name__) or compiled(kernel, *others)
from kernels_of_a_test.user import other, top
print(json.dumps([top(1.0), other(1.0), names]))
"""


@pytest.mark.costly
def test_two_checkouts_share_what_is_equal_in_both(tmp_path, package):
    """And an edit in one of them compiles what it changes, there."""
    package()
    for checkout in ("first", "second"):
        shutil.copytree(tmp_path / "kernels_of_a_test", tmp_path / checkout / "kernels_of_a_test")

    def run(checkout):
        environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
        command = [sys.executable, "-c", SCRIPT.format(root=str(ROOT)), str(tmp_path / checkout)]
        done = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=300)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    expected, twice, compiled = run("first")
    assert compiled == ["top", "other"] and twice == 2.0
    assert run("second") == [expected, 2.0, []]
    inner = tmp_path / "second/kernels_of_a_test/deep/inner.py"
    inner.write_text(inner.read_text().replace("x - 1.0", "x - 2.0"))
    changed, _, compiled = run("second")
    assert compiled == ["top"] and changed != expected
    assert run("first") == [expected, 2.0, []]
