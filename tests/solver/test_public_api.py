"""Every public function of the solver refuses what it cannot use, and names it.

What is public is found by inspection: a new function without an entry in `tests.solver.calls` fails here. An entry
gives, for every parameter, a value that is right and those that are wrong; one call is made for each of these.
"""

import pytest

from solver import ParameterError
from tests.public import assert_wrong_calls_are_refused, public
from tests.solver.calls import CALLS, FURTHER

MODULES = ("solver", "solver.boundaries", "solver.regions", "solver.stability", "solver.timedomain")

PUBLIC = public(MODULES)

#: Classes of results: users read them and do not make them.
RESULTS = {
    "solver.Backbone",
    "solver.FreeVibration",
    "solver.Curve",
    "solver.CycleFit",
    "solver.Row",
    "solver.RowSolutions",
    "solver.Solutions",
    "solver.SteadyMotion",
    "solver.boundaries.BoundaryCurve",
    "solver.regions.Regions",
    "solver.stability.Stability",
    "solver.timedomain.AttractorRow",
    "solver.timedomain.IsolatedBranch",
    "solver.timedomain.IsolatedBranches",
    "solver.timedomain.Measurement",
    "solver.timedomain.PeriodicOrbit",
    "solver.timedomain.Quantities",
    "solver.timedomain.SampledMotion",
    "solver.timedomain.Sections",
    "solver.timedomain.SlowRun",
    "solver.timedomain.Trajectory",
}


def asked() -> list[str]:
    """Names of what takes arguments."""
    return [name for name, one in PUBLIC.items() if one.parameters and name not in RESULTS]


def test_every_public_function_has_its_wrong_calls():
    assert set(asked()) == set(CALLS) and set(PUBLIC) >= RESULTS
    for name, entry in CALLS.items():
        given = [parameter for parameter in PUBLIC[name].parameters if parameter.kind != parameter.VAR_KEYWORD]
        if len(given) == len(PUBLIC[name].parameters):
            assert {parameter.name for parameter in given} - {"self"} == set(entry()) - {"self"}, name


@pytest.mark.parametrize("name", [*asked(), *FURTHER])
def test_what_is_right_is_taken_and_what_is_wrong_is_named(name):
    name, entry = FURTHER.get(name, (name, CALLS.get(name)))
    assert_wrong_calls_are_refused(PUBLIC[name].function, entry(), ParameterError)


def test_there_are_many():
    count = sum(len(one.wrong) for name in CALLS for key, one in CALLS[name]().items() if key != "self")
    assert count > 2500
