"""The explorer in a notebook."""

import shlex

from pipeline.config.compose import compose
from pipeline.config.places import Place
from pipeline.errors import ConfigurationError
from pipeline.explorer import answers
from pipeline.explorer.app import explorer
from pipeline.explorer.opened import Opened
from pipeline.explorer.view_state import state_of
from pipeline.plan.plan import Plan
from pipeline.plan.planning import plan as plan_of

__all__ = ["in_notebook"]


def in_notebook(path: Place, view: str):
    """The explorer of a store.

    Parameters
    ----------
    path : Place
    view : str

    Raises
    ------
    ConfigurationError
        If there is no such view, or no store any more.
    """
    opened = Opened(path)
    content = opened.content()
    state_of(view, content.allowed)
    opened.command = _command(path, content.plan)
    answers.ready(content.plan)
    opened.ready.set()
    return explorer(opened, view)


def _command(path: Place, plan: Plan) -> str:
    """The command of a plane that is called as its file in `conf/plane` is; empty where that makes another."""
    words = [f"plane={path.stem}", f"store.root={path.parent}"]
    sizes = [f"plane.sweep.num={plan.sweep.num}", f"plane.parameter.num={plan.parameter.num}"]
    try:
        usual, sized = (plan_of(compose([*words, *more])) for more in ([], sizes))
    except ConfigurationError:
        return ""
    found = (
        words
        if usual.fingerprint == plan.fingerprint
        else [*words, *sizes]
        if sized.fingerprint == plan.fingerprint
        else []
    )
    return " ".join(["python -m pipeline", *map(shlex.quote, found)]) if found else ""
