"""Every array that a plane has: its dimensions, type, fill value, attributes and files."""

from functools import cache

from pipeline.config.quantities import AMPLITUDE, READ
from pipeline.plan.axes import Axis
from pipeline.plan.plan import Plan
from pipeline.store.array_layout import ArrayLayout
from pipeline.store.attributes import LONG_NAMES, UNITS, flags, label_flags
from pipeline.store.names import ROWS
from pipeline.store.states import COMPLETE, FAILED, PENDING
from solver import EndReason, Event, ImpactState, domain_labels
from solver.stability import Instability

__all__ = ["arrays_of", "axes_in_store", "layouts_of", "row_layouts", "status_layout"]


def arrays_of(plan: Plan) -> dict[str, dict]:
    """Every array that has rows: name -> dims, dtype, fill value and attributes. `status` comes last."""
    row, column = tuple(axis.name for axis in plan.row_axes), plan.sweep.name
    cell, solution, point = (*row, column), (*row, column, "solution"), (*row, "point")
    states = flags(ImpactState, [state.symbol for state in ImpactState])

    def spec(dims, dtype, fill, long_name, units="1", **attributes):
        return {
            "dims": dims,
            "dtype": dtype,
            "fill": fill,
            "attributes": {"long_name": long_name, **({"units": units} if units else {}), **attributes},
        }

    nan = float("nan")
    certified = spec(
        cell,
        "int8",
        0,
        "1: the solutions are proven to be all of them",
        None,
        flag_values=[0, 1],
        flag_meanings="undecided proven",
    )
    return {
        "n_solutions": spec(cell, "uint8", 255, "number of periodic solutions; 255: not computed"),
        "n_stable": spec(cell, "uint8", 255, "number of statically stable solutions; 255: not computed"),
        "domain": spec(
            cell,
            "uint16",
            0,
            "n/I label of the solution domain; 0: not computed",
            None,
            **_domain_flags(plan.max_solutions),
        ),
        **{one.name: spec(solution, "float64", nan, one.title, one.unit) for one in READ},
        "amplitude": spec(solution, "float64", nan, AMPLITUDE.title, AMPLITUDE.unit),
        "phase": spec(solution, "float64", nan, "phase of the fundamental of the mesh displacement", "rad"),
        "stable": spec(
            solution,
            "int8",
            -1,
            "static stability; -1: no such solution",
            None,
            flag_values=[-1, 0, 1],
            flag_meanings="no_solution unstable stable",
        ),
        "impact": spec(solution, "int8", -1, "impact state; -1: no such solution", None, **states),
        "instability": spec(
            solution,
            "int8",
            -1,
            "dynamic stability: how the motion is unstable; -1: no such solution",
            None,
            **flags(Instability),
        ),
        "multiplier": spec(solution, "float64", nan, "largest modulus of the multipliers"),
        **(_order_h_arrays(spec, solution, point) if plan.solver["balance"] == "galerkin" else {}),
        "open": spec(
            cell,
            "int8",
            0,
            "1: solutions above the amplitude ceiling are not excluded",
            None,
            flag_values=[0, 1],
            flag_meanings="closed open",
        ),
        **({"certified": certified} if plan.solver["certify"] == "all" else {}),
        "branches/n_folds": spec(row, "int16", -1, "folds of all branches"),
        "branches/n_points": spec(row, "int32", 0, "number of branch points"),
        f"branches/{column}": spec(point, "float64", nan, LONG_NAMES[column], UNITS.get(column, "1")),
        "branches/mean": spec(point, "float64", nan, "mean of the mesh displacement"),
        "branches/cos": spec(point, "float64", nan, "cosine amplitude of the mesh displacement"),
        "branches/sin": spec(point, "float64", nan, "sine amplitude of the mesh displacement"),
        "branches/amplitude": spec(point, "float64", nan, AMPLITUDE.title, AMPLITUDE.unit),
        "branches/arclength": spec(point, "float64", nan, "arc length along the branch, in scaled unknowns"),
        "branches/stable": spec(
            point,
            "int8",
            -1,
            "static stability; -1: no point",
            None,
            flag_values=[-1, 0, 1],
            flag_meanings="no_point unstable stable",
        ),
        "branches/impact": spec(point, "int8", -1, "impact state; -1: no point", None, **states),
        "branches/branch": spec(point, "int16", -1, "which connected curve the point belongs to; -1: no point"),
        "branches/event": spec(
            point, "int8", -1, "what is special about the point; -1: no point", None, **flags(Event)
        ),
        "branches/end_reason": spec(
            (*row, "branch_number", "end"),
            "int8",
            0,
            "why the branch ends; 0: no such branch",
            None,
            **flags(EndReason),
        ),
        "message": spec(row, "str", "", "why the row failed, or what could not be decided in it; else empty", None),
        "status": spec(
            row,
            "uint8",
            PENDING,
            "state of the row",
            None,
            flag_values=[PENDING, COMPLETE, FAILED],
            flag_meanings="pending complete failed",
        ),
    }


@cache
def _domain_flags(max_solutions: int) -> dict:
    """CF attributes of labels: there are hundreds."""
    return label_flags(domain_labels(max_solutions))


def axes_in_store(plan: Plan) -> dict[str, Axis]:
    """Every array that holds the values of an axis, each in one chunk: name -> axis."""
    rows = {f"{ROWS}/{axis.name}": axis for axis in plan.row_axes}
    return {axis.name: axis for axis in plan.axes} | rows


def layouts_of(plan: Plan) -> dict[str, ArrayLayout]:
    """Where every array of a plane has its chunks: name -> layout."""
    axes = {
        name: ArrayLayout(name, (axis.num,), (axis.num,), "float64", (axis.name,), 0.0)
        for name, axis in axes_in_store(plan).items()
    }
    return axes | row_layouts(plan)


def status_layout(plan: Plan) -> ArrayLayout:
    """The layout of `status` alone, which is asked for block by block."""
    names, shape = zip(*((axis.name, axis.num) for axis in plan.row_axes), strict=True)
    return ArrayLayout("status", shape, (*(1,) * (len(shape) - 1), plan.rows_per_block), "uint8", names, PENDING)


def row_layouts(plan: Plan) -> dict[str, ArrayLayout]:
    """The layouts of the arrays that have rows; a chunk holds the rows of one block. `status` comes last."""
    sizes = {
        **{axis.name: axis.num for axis in plan.axes},
        "solution": plan.max_solutions,
        "point": plan.max_points,
        "branch_number": plan.max_branches,
        "end": 2,
        "component": 2 * plan.solver["order"] * plan.solver["period"] + 1,
    }
    along_rows = (1,) * (len(plan.row_axes) - 1) + (plan.rows_per_block,)
    layouts = {}
    for name, spec in arrays_of(plan).items():
        shape = tuple(sizes[dim] for dim in spec["dims"])
        kind = {"str": "string"}.get(spec["dtype"], spec["dtype"])
        fill = spec["fill"] if spec["fill"] == spec["fill"] else "NaN"
        layouts[name] = ArrayLayout(name, shape, (*along_rows, *shape[len(along_rows) :]), kind, spec["dims"], fill)
    return layouts


def _order_h_arrays(spec, solution: tuple[str, ...], point: tuple[str, ...]) -> dict[str, dict]:
    """What only a balance of order H has."""
    nan = float("nan")
    harmonics = "mean of the mesh displacement, then cosine and sine amplitude of each harmonic of the base frequency"
    return {
        "motion": spec((*solution, "component"), "float64", nan, harmonics),
        "branches/motion": spec((*point, "component"), "float64", nan, harmonics),
    }
