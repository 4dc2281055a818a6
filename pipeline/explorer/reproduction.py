"""What makes a view again: the Python lines, and the shell command."""

from pipeline.config.places import Place
from pipeline.explorer.view_state import ViewState, query_of
from pipeline.plan.plan import Plan

__all__ = ["python_lines", "shell_command"]


def python_lines(state: ViewState, path: Place, plan: Plan) -> str:
    """Lines of Python that ask for what the view shows, and open the view itself.

    Parameters
    ----------
    state : ViewState
    path : Place
        The store.
    plan : Plan
        Its plan.
    """
    lines = ["import pipeline", "", f"plane = pipeline.open_plane({str(path)!r})"]
    fixed = dict(state.fixed)
    if state.at is not None and not fixed:
        x, p = state.at
        names, physical = (plan.sweep.name, plan.parameter.name), ", physical=True" if state.physical else ""
        lines.append(f"curves = plane.curve_at({names[1]}={p!r}{physical})")
        lines.append(f"motions = plane.motions_at({names[0]}={x!r}, {names[1]}={p!r}{physical})")
    elif state.at is not None:
        x, p = state.at
        lines[1:1] = ["from pipeline.explorer import answers"]
        lines.append(f"changed = answers.Answers(plane.plan).plan({fixed!r})")
        lines.append(f"curves = answers.row(changed, {p!r})")
        lines.append(f"motions = answers.motions(changed, {x!r}, {p!r})")
    lines.append(f"plane.explore({query_of(state)!r})")
    return "\n".join(lines)


def shell_command(state: ViewState, command: str) -> str:
    """The command that opens the view.

    Parameters
    ----------
    state : ViewState
    command : str
        That of the plane, "python -m pipeline plane=omega_fe".
    """
    query = query_of(state)
    # Quoted once for Hydra, whose grammar has another meaning for = and commas, and once for the shell: a query has
    # neither quotes nor anything that a shell would read.
    view = [f"\"explore.view='{query}'\""] if query else []
    return " ".join([command, "'stages=[explore]'", *view])
