"""A store that pages show: what all of them have in common, read anew when the store has changed."""

import contextlib
import threading

import numpy as np

from pipeline import store
from pipeline.config.places import Place
from pipeline.errors import ConfigurationError, StoreError
from pipeline.explorer.answers import Answers
from pipeline.explorer.layer_data import Layer
from pipeline.explorer.layers import layer, layer_names, layer_sketch
from pipeline.explorer.view_state import Allowed, allowed_of
from pipeline.plan.plan import Plan
from pipeline.plane.stored import StoredPlane
from pipeline.store.files import files_at
from pipeline.store.names import METADATA

__all__ = ["Content", "Opened", "said"]


class Content:
    """What a store holds at one time.

    Parameters
    ----------
    path : Place
    plan : Plan
    """

    def __init__(self, path: Place, plan: Plan):
        self.path, self.plan, self.answers = path, plan, Answers(plan)
        self.plane = StoredPlane(path, plan)
        self.allowed: Allowed = allowed_of(plan, layer_names(self.plane))
        self._layers: dict[tuple[str, bool], Layer] = {}
        self._alone = threading.Lock()

    def shown(self, physical: bool) -> StoredPlane:
        """The plane in one of its units."""
        return StoredPlane(self.path, self.plan, physical=physical)

    def first_layer(self, name: str, physical: bool) -> tuple[Layer | None, bool]:
        """What can be shown at once of a layer, and whether that is the layer itself."""
        made = self._layers.get((name, physical))
        return (layer_sketch(self.plane, name, physical=physical), False) if made is None else (made, True)

    def layer(self, name: str, physical: bool) -> Layer:
        """What the map shows, made once."""
        with self._alone:
            if (name, physical) not in self._layers:
                self._layers[name, physical] = layer(self.plane, name, physical=physical)
            return self._layers[name, physical]


class Opened:
    """A store that is shown; asked by several pages, each in its own thread or not.

    Parameters
    ----------
    path : Place
    command : str
        That of its plane, "python -m pipeline plane=omega_fe"; empty where it is not known.
    """

    def __init__(self, path: Place, command: str = ""):
        self.path, self.command = path, command
        #: Set once kernels are loaded: answers wait for it.
        self.ready = threading.Event()
        self._known: tuple[tuple, Content] | None = None
        self._alone = threading.Lock()

    def content(self) -> Content:
        """What the store holds now.

        Raises
        ------
        StoreError
            If there is no store any more, or it cannot be read.
        """
        with self._alone:
            state = self._state()
            if self._known is None or self._known[0] != state:
                plan = store.read_plan(self.path)
                if plan.parameter2 is not None:
                    raise StoreError(
                        f"{self.path} is a volume: plane.layer=VALUE takes out the plane of one layer, which can be "
                        "explored"
                    )
                self._known = state, Content(self.path, plan)
            return self._known[1]

    def _state(self) -> tuple:
        """Changes when somebody writes into the store."""
        try:
            versions = files_at(self.path).versions()
            documents = sorted(item for item in versions.items() if item[0].rpartition("/")[2] == METADATA)
            return (*documents, np.asarray(store.statuses(self.path)).tobytes())
        except Exception as error:
            raise StoreError(said(error, self.path)) from None


def said(error: Exception, path: Place) -> str:
    """What a page says of an error: damage of the store, or that it is gone, if that is what it is."""
    if not store.exists(path):
        return f"{path} is gone: the command that made it makes it again"
    if isinstance(error, ConfigurationError):
        return str(error)
    damage = None
    with contextlib.suppress(OSError, ValueError, KeyError):
        damage = store.damage_error(path)
    return str(damage) if damage is not None else f"{type(error).__name__}: {' '.join(str(error).split())}"
