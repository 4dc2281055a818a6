"""Stored planes as statements read them: regions by resonance, divided once."""

from collections.abc import Mapping
from functools import cache

from pipeline.config.compose import compose
from pipeline.config.places import Place
from pipeline.errors import StoreError
from pipeline.plan.numerics import model_at
from pipeline.plan.plan import Plan
from pipeline.plan.planning import plan
from pipeline.plane.regions import stored_regions
from pipeline.plane.resonances import Resonance, common_resonances
from pipeline.store import read_plan, store_path
from solver import Model
from solver.model.checks import instance_of
from solver.regions import RegionError, Regions
from solver.regions.bands import Line, lines

__all__ = ["Planes", "default_model", "default_value"]


def default_model(gear: str) -> Model:
    """A gear of `conf/gear` as it is there."""
    settings = compose([f"gear={gear}"])
    there = plan(settings)
    return model_at(there, getattr(settings.config.gear, there.parameter.name), there.sweep.low)


def default_value(parameter: str) -> float:
    """A parameter of the published gear."""
    return float(getattr(compose(["gear=published"]).config.gear, parameter))


class Planes:
    """Stores by the name of their plane.

    Parameters
    ----------
    paths : mapping of str to Place
        Of the planes that there are; statements about others say that they cannot be computed.

    Raises
    ------
    solver.ParameterError
        If they are none.
    """

    def __init__(self, paths: Mapping[str, Place]):
        instance_of("planes", paths, Mapping)
        self.paths = {name: store_path(f"planes[{name!r}]", path) for name, path in paths.items()}
        self.plan, self.whole, self.part = cache(self._plan), cache(self._whole), cache(self._part)

    def _plan(self, plane: str) -> Plan:
        """Plan of a plane of the published gear, at first order.

        Raises
        ------
        StoreError
            If there is none, or it is another one.
        """
        if plane not in self.paths:
            raise StoreError(f"no store of {plane} is given")
        path = self.paths[plane]
        stored, wanted = read_plan(path), plan(compose([f"plane={plane}"]))
        axes = [tuple(axis.name for axis in one.axes) for one in (stored, wanted)]
        if axes[0] != axes[1]:
            raise StoreError(f"{path} is a plane {' x '.join(axes[0])}, not {' x '.join(axes[1])}")
        if stored.gear != wanted.gear:
            changed = sorted(key for key in wanted.gear if stored.gear.get(key) != wanted.gear[key])
            raise StoreError(f"{path} is of another gear than the published one: {', '.join(changed)}")
        if not stored.is_first_order:
            raise StoreError(f"{path} is not balanced at first order")
        return stored

    def _whole(self, plane: str) -> Regions:
        """Regions of a plane."""
        self.plan(plane)
        try:
            return stored_regions(self.paths[plane])
        except RegionError as error:
            raise StoreError(f"{self.paths[plane]} has no regions of one label: {error}") from error

    def _part(self, plane: str, resonance: str) -> Regions:
        """Regions of a plane at one resonance."""
        one, axis = self.resonance(plane, resonance), self.plan(plane).sweep
        low, high = one.window(axis.low, axis.high)
        if not low < one.natural < high:
            raise StoreError(f"{self.paths[plane]} does not cover the {resonance} resonance, omega = {one.natural:.4f}")
        try:
            return self.whole(plane).within((low, high))
        except RegionError as error:
            raise StoreError(f"{self.paths[plane]} has no regions of one label: {error}") from error

    def resonance(self, plane: str, name: str) -> Resonance:
        """One resonance of a plane."""
        pair = common_resonances(self.plan(plane))
        if pair is None:
            raise StoreError(f"{self.paths[plane]}: the natural frequencies move with the row parameter")
        return next(one for one in pair if one.name == name)

    def default_line(self, plane: str, resonance: str) -> Line:
        """The labels of the row of the published gear's value, at one resonance; raises as `default`."""
        (line,) = lines(self.part(plane, resonance), [self.default(plane)])
        return line

    def default(self, plane: str) -> float:
        """The published gear's value of a plane's row parameter.

        Raises
        ------
        StoreError
            If the plane does not reach it.
        """
        axis = self.plan(plane).parameter
        value = default_value(axis.name)
        if not axis.low <= value <= axis.high:
            raise StoreError(f"{self.paths[plane]} does not reach {axis.name} = {value:g}")
        return value
