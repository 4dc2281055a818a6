"""Five hundred command lines that nobody should type, drawn with a seed: each is done or refused in one line."""

import random
import signal

import pytest

from pipeline.__main__ import main
from pipeline.cli.arguments import OPTIONS
from pipeline.config.compose import _keys, compose, expand
from pipeline.config.default_name import is_name
from pipeline.config.typed import GROUPS
from pipeline.errors import ConfigurationError
from pipeline.run.preparation import prepare
from pipeline.stages import STAGES
from tests.conftest import slow_but

_DRAWS, _EACH = 10, 50

#: Values of every kind that has ever ended a program like this one, and some that are allowed.
_VALUES = (
    *(
        "null",
        "[]",
        "{}",
        "''",
        "true",
        "[[1]]",
        "{a:1}",
        "[1,[2,[3]]]",
        "{name:b,min:0.1,max:1,num:3}",
        "[0.5,1,0,0.3]",
    ),
    *("0", "1", "-1", "0.5", "3", "1e400", "1e-400", "nan", "inf", "-inf", "1_0", "0x10", "9" * 99, "9" * 10_000),
    *(
        "abc",
        "omega",
        "b",
        "miter",
        "hb",
        "none",
        "scheduler",
        "a" * 9000,
        "日本",
        "12 um",
        "5 parsec",
        "1 1/0",
        "90 N*m",
    ),
    *("1,2", "range(0,3)", "range(0,1e12)", "shuffle(range(0,1e9))", "range(1,0,0)", "choice(a,b)", "interval(0,1)"),
    *("glob(*)", "glob(o*)", "sort(3,1)", "tag(a,1)", "cast(1)", "int(x)", "[" * 1000 + "]" * 1000, "{a:" * 400),
    *("${gear.b}", "${nope}", "${oc.env:HOME}", "${oc.env:NOT_THERE}", "${", "${oc.create:1}", "${${gear.b}}"),
    *("'", "\\", "$", "\n", "\x1b[31m", "\udcff", "..", "../../x", "con", "/etc/passwd", "/dev/zero", "a b"),
    *("tcp://1:1", "tls://x:1", "ucx://x:1", "foo", "1MB", "1e999GB", "-1GB", "auto"),
    *(f"[{entry.name}]" for entry in STAGES if not entry.several_planes),
)
_OPTIONS = (*OPTIONS, "-c", "-i", "-p", "-cd", "-sc", "-cp", "-cn", "--hydra-help", "--cfg=all", "--resolve", "--", "-")


def _override(draw: random.Random, keys: list[str]) -> str:
    key, value = draw.choice(keys), draw.choice(_VALUES)
    prefix = draw.choice(["", "", "", "", "", "+", "++", "~"])
    return draw.choice([f"{prefix}{key}={value}"] * 12 + [f"{prefix}{key}@x={value}", key, f"{key}.x={value}", value])


def _line(draw: random.Random, keys: list[str]) -> list[str]:
    words = [_override(draw, keys) for _ in range(draw.choice([1, 1, 1, 2, 3]))]
    if draw.random() < 0.3:
        words.insert(draw.randrange(len(words) + 1), draw.choice(_OPTIONS))
    return words


@pytest.fixture
def in_time():
    """No case may take longer than any could: a wait without end is a failure, and not a test that never ends."""

    def late(*_):
        raise AssertionError("this command line takes for ever")

    before = signal.signal(signal.SIGALRM, late)
    signal.alarm(200)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


def _prepared(words: list[str]) -> str | None:
    """Everything that a run does before it begins; what is said against it."""
    try:
        for combination in expand(words)[:3]:
            settings = compose(combination)
            assert is_name(settings.store_name)
            prepare(settings)
    except ConfigurationError as error:
        return str(error)
    return None


@pytest.mark.parametrize(("number",), slow_but([(0,), (1,), (3,)], [(number,) for number in range(_DRAWS)]))
def test_whatever_is_typed_is_done_or_refused_in_one_line(number, tmp_path, monkeypatch, capsys, in_time):
    monkeypatch.chdir(tmp_path)
    draw, keys = random.Random(number), [*_keys(), *GROUPS, *GROUPS, "hydra.run.dir", "gear/thermal", "nope", ""]
    refused = 0
    for _ in range(_EACH):
        words = _line(draw, keys)
        shown = [word[:60] for word in words]
        if any(word.startswith("-") for word in words) or draw.random() < 0.3:
            # With --cfg nothing is run, whatever it is that was typed.
            status = main(["--cfg", "job", *words])
            out, err = capsys.readouterr()
            assert status in (0, 2), shown
            assert (status == 0) == (err == ""), shown
            said = err.removesuffix("\n") if status else None
        else:
            said = _prepared(words)
        if said is not None:
            refused += 1
            assert said.isprintable() and 10 < len(said) < 4100, (shown, said)
            assert "Traceback" not in said and "object at 0x" not in said, (shown, said)
    assert 0.3 * _EACH < refused <= _EACH
    assert list(tmp_path.iterdir()) == []
