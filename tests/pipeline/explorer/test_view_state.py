"""The address of a view: what is shown is read back, and nothing else is."""

import ast
import shlex

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.config.compose import compose
from pipeline.errors import ConfigurationError
from pipeline.explorer.reproduction import python_lines, shell_command
from pipeline.explorer.view_state import ViewState, allowed_of, query_of, state_of
from tests.pipeline.planes import small_plan

PLAN = small_plan("plane=omega_fe")
LAYERS = ("domains", "dynamic", "rms")
ALLOWED = allowed_of(PLAN, LAYERS)


def within(low, high):
    return st.floats(low, high).map(lambda value: value + 0.0)


X, P = (within(axis.low, axis.high) for axis in (PLAN.sweep, PLAN.parameter))
FIXED = {name: within(low, high) for name, (low, high) in ALLOWED.fixed.items() if name in ("b", "alpha", "f_pv")}
STATES = st.builds(
    ViewState,
    layer=st.sampled_from(LAYERS),
    at=st.none() | st.tuples(X, P),
    pin=st.none() | st.tuples(X, P),
    fixed=st.dictionaries(st.sampled_from(sorted(FIXED)), st.none())
    .flatmap(lambda names: st.fixed_dictionaries({name: FIXED[name] for name in names}))
    .map(lambda fixed: tuple(sorted(fixed.items()))),
    basins=st.booleans(),
    design=st.none() | st.tuples(X, P),
    tolerances=st.tuples(*(within(0.0, 0.5 * (axis.high - axis.low)) for axis in (PLAN.sweep, PLAN.parameter))),
    window=st.none()
    | st.tuples(X, X, P, P)
    .map(lambda w: (min(w[:2]), max(w[:2]), min(w[2:]), max(w[2:])))
    .filter(lambda w: w[0] < w[1] and w[2] < w[3]),
).flatmap(
    lambda state: st.one_of(
        st.just({}),
        st.builds(lambda n: {"motion": n}, st.from_regex(r"\A([A-P]|[1-9][0-9]?)\Z")),
        st.builds(lambda a, b: {"start": (a + 0.0, b + 0.0)}, *(st.floats(-100.0, 100.0),) * 2),
    ).map(lambda more: ViewState(**{**vars(state), **more}))
)


@pytest.mark.costly
@given(STATES)
@settings(max_examples=60, deadline=None)
def test_a_view_is_its_address_its_python_lines_and_its_shell_command(state):
    assert state_of(query_of(state), ALLOWED) == state
    # What the lines ask to be explored is the same view.
    calls = [node for node in ast.walk(ast.parse(python_lines(state, "a.zarr", PLAN))) if isinstance(node, ast.Call)]
    (view,) = [call.args[0].value for call in calls if getattr(call.func, "attr", "") == "explore"]
    assert state_of(view, ALLOWED) == state
    # And so is what the shell and Hydra make of the command.
    words = shlex.split(shell_command(state, "python -m pipeline plane=omega_fe"))
    assert words[:3] == ["python", "-m", "pipeline"]
    config = compose(words[3:]).config
    assert config.stages == ["explore"] and state_of(config.explore.view or "", ALLOWED) == state


def test_the_usual_view_has_an_empty_address():
    assert query_of(ViewState()) == "" and state_of("", ALLOWED) == ViewState() == state_of("?", ALLOWED)


@pytest.mark.parametrize(
    ("query", "named"),
    [
        ("layer=../../etc/passwd", "layer"),
        ("at=0.6", "at"),
        ("at=0.6,nan", "at"),
        ("at=0.6,1e400", "at"),
        ("pin=9,0.2", "pin"),
        ("b=-1", "b"),
        ("b=__import__('os')", "b"),
        ("omega=0.5", "omega"),
        ("motion=0", "motion"),
        ("motion=²", "motion"),
        ("motion=1&start=0,0", "start"),
        ("start=1e9,0", "start"),
        ("basins=yes", "basins"),
        ("design=0.6,0.2,0.1", "design"),
        ("tolerances=-0.1,0", "tolerances"),
        ("window=0.9,0.6,0.1,0.2", "window"),
        ("units=physical", "units"),
        ("b=0.5&b=0.6", "view"),
        ("path=/etc", "path"),
        ("x" * 3000, "view"),
        ("%00=1", "view"),
    ],
)
def test_what_no_view_shows_is_refused_by_name(query, named):
    with pytest.raises(ConfigurationError, match=named) as told:
        state_of(query, ALLOWED)
    assert "\n" not in str(told.value)


@given(st.text(max_size=200))
def test_any_text_is_a_view_or_is_refused(text):
    try:
        state = state_of(text, ALLOWED)
    except ConfigurationError:
        return
    assert state_of(query_of(state), ALLOWED) == state


def test_physical_units_are_of_gears_that_have_them():
    allowed = allowed_of(small_plan("gear=miter"), LAYERS)
    assert state_of("units=physical", allowed).physical
