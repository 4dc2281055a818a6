"""Places whose motions are known (docs/physics.md, sections 8 and 9)."""

import functools

from pipeline.analysis.motion.motions import Motions, motions_at
from pipeline.config.compose import compose
from pipeline.plan.planning import plan
from tests.pipeline.analysis.margins.spur import SPUR

__all__ = ["MITER", "PUBLISHED", "SPUR", "found_at", "plan_of"]

SIZES = ("plane.sweep.num=20", "plane.parameter.num=3")
PUBLISHED = ("plane=omega_fe",)
MITER = ("plane=omega_fe", "gear=miter")


@functools.cache
def plan_of(*overrides: str):
    """The plan of a plane of few cells."""
    return plan(compose([*SIZES, *overrides]))


@functools.cache
def found_at(x: float, p: float, *overrides: str) -> Motions:
    """The motions at a place, from 20 random starts."""
    settings = compose(["attractors.starts=20", *overrides]).config.attractors
    return motions_at(plan_of(*(word for word in overrides if not word.startswith("attractors."))), x, p, settings)
