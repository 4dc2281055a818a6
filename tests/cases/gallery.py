"""All published cases, in the order of the page."""

from tests.cases import (
    asymmetric_clearance,
    bilinear_coupling,
    bilinear_oscillator,
    event_driven,
    free_flight,
    impact_pair,
    kahraman_singh,
    mathieu,
    stop,
    two_masses,
    two_stops,
    undamped_clearance,
)

__all__ = ["CASES"]

CASES = tuple(
    module.CASE
    for module in (
        kahraman_singh,
        impact_pair,
        mathieu,
        asymmetric_clearance,
        free_flight,
        undamped_clearance,
        bilinear_oscillator,
        stop,
        two_stops,
        two_masses,
        bilinear_coupling,
        event_driven,
    )
)
