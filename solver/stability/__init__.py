"""Dynamic stability of periodic motions: Hill's method and Floquet's, each checking the other.

It is imported on its own, because its kernels are not needed to find motions.
"""

from solver.stability.assessment import assess, both_multipliers, hill_multipliers, truncation_of
from solver.stability.floquet import monodromies, motion_multipliers, multipliers
from solver.stability.hill import Truncation, centred_exponents, window_exponents
from solver.stability.hill_roots import condensed_exponents
from solver.stability.instability import Instability, Stability, classify, combine
from solver.stability.system_row import SystemRow, system_row

__all__ = [
    "Instability",
    "Stability",
    "SystemRow",
    "Truncation",
    "assess",
    "both_multipliers",
    "centred_exponents",
    "classify",
    "combine",
    "condensed_exponents",
    "hill_multipliers",
    "monodromies",
    "motion_multipliers",
    "multipliers",
    "system_row",
    "truncation_of",
    "window_exponents",
]
