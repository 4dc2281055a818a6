"""What can be read of every motion: the one place that says how each quantity is called, shown and scaled.

Names are those of the variables in stores, of `figures.quantity` and of the fields of `solver.Quantities`.
"""

from dataclasses import dataclass

from solver.contact.quantities import Slot

__all__ = ["AMPLITUDE", "QUANTITIES", "READ", "Quantity"]


@dataclass(frozen=True)
class Quantity:
    """One quantity of a motion.

    Parameters
    ----------
    name : str
    title : str
        What it is, in full: `long_name` of the variable.
    label : str
        What it is, as short as an axis needs.
    symbol : str
        Mathematical text, without the dollar signs.
    scale : str or None
        What turns it into a physical value, one of `solver.Scales`; None of a ratio, which has no unit.
    signed : bool
        Whether it may be below 0: axes of the others begin there.
    """

    name: str
    title: str
    label: str
    symbol: str
    scale: str | None = "length"
    signed: bool = False

    @property
    def slot(self) -> Slot | None:
        """Where `solver.fill_quantities` puts it; None of the amplitude, which a solution itself has."""
        return Slot.__members__.get(self.name.upper())

    @property
    def unit(self) -> str:
        """Unit of the stored values: all are dimensionless."""
        return "1"

    @property
    def reference(self) -> str:
        """What the dimensionless value is in units of, as mathematical text; empty of a ratio."""
        return {None: "", "length": "b_c", "velocity": r"b_c \Omega_n", "force": "k_m b_c"}[self.scale]


_ALL = (
    Quantity("amplitude", "amplitude of the fundamental of the mesh displacement", "amplitude", r"\lambda_a"),
    Quantity(
        "lowest", "lowest mesh displacement over the period", "lowest displacement", r"\lambda_{min}", signed=True
    ),
    Quantity(
        "highest", "highest mesh displacement over the period", "highest displacement", r"\lambda_{max}", signed=True
    ),
    Quantity("mean", "mean of the mesh displacement", "mean", r"\lambda_m", signed=True),
    Quantity("rms", "root mean square of the varying part of the mesh displacement", "RMS", r"\lambda_{rms}"),
    Quantity("peak_to_peak", "peak to peak of the mesh displacement", "peak to peak", r"\lambda_{pp}"),
    Quantity(
        "error_lowest", "lowest dynamic transmission error", "lowest transmission error", r"\psi_{min}", signed=True
    ),
    Quantity(
        "error_highest", "highest dynamic transmission error", "highest transmission error", r"\psi_{max}", signed=True
    ),
    Quantity(
        "error_rms",
        "root mean square of the varying part of the dynamic transmission error",
        "RMS of transmission error",
        r"\psi_{rms}",
    ),
    Quantity(
        "error_peak_to_peak",
        "peak to peak of the dynamic transmission error",
        "peak to peak of transmission error",
        r"\psi_{pp}",
    ),
    Quantity("dynamic_factor", "dynamic factor: largest mesh force over the static one", "dynamic factor", "K_v", None),
    Quantity("contact_loss", "share of the period without contact", "contact loss", "T_0/T", None),
    Quantity(
        "impact_velocity",
        "largest speed of the mesh displacement where teeth meet again",
        "impact velocity",
        "v_i",
        "velocity",
    ),
    Quantity("support_force", "largest force of a support", "support force", "F_b", "force"),
)

#: Name -> quantity.
QUANTITIES = {one.name: one for one in _ALL}
#: Of them, the one that the solutions of a first harmonic are: what maps and curves were made of.
AMPLITUDE = QUANTITIES["amplitude"]
#: Those that are read of a motion, in the order of `Slot`.
READ = tuple(sorted((one for one in _ALL if one.slot is not None), key=lambda one: one.slot))
