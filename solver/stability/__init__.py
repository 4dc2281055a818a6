"""Dynamic stability of periodic motions by Floquet's theory: multipliers, their meaning, bifurcations of branches."""

from solver.stability.assessment import Stability, assess, classify, monodromies, motion_multipliers, multipliers
from solver.stability.instability import Instability

__all__ = ["Instability", "Stability", "assess", "classify", "monodromies", "motion_multipliers", "multipliers"]
