"""Calls of every public function of the solver, right ones and wrong ones.

`CALLS` has for every function, by name, the arguments of one call as `tests.public.Argument`, made when they are asked
for; `self` is the object of a method. `FURTHER` has more calls, each with the name of what it calls.
"""

from tests.solver.calls import gears, motions, planes, rows

__all__ = ["CALLS", "FURTHER"]

CALLS = gears.CALLS | rows.CALLS | planes.CALLS | motions.CALLS
FURTHER = rows.FURTHER | planes.FURTHER | motions.FURTHER
