"""How measured things read in a cell: intervals, shares, shifts, edges; one wording for every format for readers."""

from pipeline.tables.bands import BandAtResonance
from pipeline.tables.classes import percent
from pipeline.tables.edges import Edge, band_edges
from pipeline.tables.rows import RowAtResonance
from solver import ImpactState

__all__ = ["changes", "impact_states", "jump_size", "jumps", "labels", "peak_shift"]

NONE, NO_REGION = "none", "no region"


def ranges(parts) -> str:
    """Ranges of the row parameter to 1e-6, or a dash."""
    return "; ".join(f"{low:.6f}–{high:.6f}" for low, high in parts) or "–"


def jumps(band: BandAtResonance) -> str:
    """Multivalued intervals in the first and the last row, and the envelope of all rows where it says more."""
    first, last = _intervals(band.rows[0]), _intervals(band.rows[-1])
    if not band.jump_rows:
        return NONE
    text = first if first == last else f"{first} to {last}"
    envelope = "{:.4f}–{:.4f}".format(*band.envelope)
    return text if text == envelope else f"{text}; all within {envelope}"


def _intervals(row: RowAtResonance) -> str:
    return " and ".join(f"{low:.4f}–{high:.4f}" for low, high in row.intervals) or NONE


def jump_size(band: BandAtResonance) -> str:
    """Rows with a jump, and the widest interval."""
    if not band.jump_rows:
        return f"0 of {len(band.rows)}"
    widest = max(band.widths)
    several = f", up to {band.intervals_per_row} at once" if band.intervals_per_row > 1 else ""
    return (
        f"{band.jump_rows} of {len(band.rows)}{several}; "
        f"{widest * band.resonance.natural:.4f} ({100.0 * widest:.1f} %)"
    )


def impact_states(band: BandAtResonance) -> str:
    """Impact states of stable solutions with their shares of the region's cells."""
    met = [
        f"{state.symbol}: {percent(band.share(count))}"
        for state, count in zip(ImpactState, band.states, strict=True)
        if count
    ]
    return ", ".join(met) or NO_REGION


def labels(band: BandAtResonance) -> str:
    """n/I labels of the region with their shares, the most frequent first."""
    return ", ".join(f"{label} {percent(band.share(count))}" for label, count in band.labels) or NO_REGION


def peak_shift(band: BandAtResonance) -> str:
    """Shift of the peak in percent from the first to the last row that has one, its range, and rows without a peak."""
    shifts = [100.0 * shift for shift in band.shifts]
    if not shifts:
        return _without_peak(band)
    first, last, low, high = (_signed(value) for value in (shifts[0], shifts[-1], min(shifts), max(shifts)))
    text = f"{first} %" if first == last else f"{first} to {last} %"
    # A range that only rounding sets apart from the two ends says nothing.
    if min(shifts) < min(shifts[0], shifts[-1]) - 0.1 or max(shifts) > max(shifts[0], shifts[-1]) + 0.1:
        text += f"; range {low} to {high} %"
    return f"{text}; {_without_peak(band)}" if len(shifts) < len(band.rows) else text


def _without_peak(band: BandAtResonance) -> str:
    """How many rows have no peak, and in how many of them it may lie above the amplitude ceiling."""
    missing = [row for row in band.rows if row.peak is None]
    unbounded = sum(row.open > 0 for row in missing)
    above = f", {unbounded} of them open above the amplitude ceiling" if unbounded else ""
    return f"no peak in {len(missing)} of {len(band.rows)} rows{above}"


def _signed(value: float) -> str:
    text = f"{value:+.1f}"
    return "0.0" if float(text) == 0.0 else text.replace("-", "−")


def changes(band: BandAtResonance, sign: str) -> str:
    """Where jumps, loss of contact and double-sided impact appear or end in the parameter."""
    where = {"inside": "", "below": ", below the band", "above": ", above the band"}
    parts = [
        f"{what} {'from' if edge.appears else 'up to'} {sign} = {_with_resolution(edge)}{where[edge.place]}"
        for what, all_edges in (
            ("jump", band.jump_edges),
            ("contact loss", band.contact_loss_edges),
            ("double-sided impact", band.double_sided_edges),
        )
        for edge in band_edges(all_edges, band.values[0], band.values[-1])
    ]
    return "; ".join(parts) or NONE


def _with_resolution(edge: Edge) -> str:
    """Middle and half width with as few decimals as leave the half width right within a twentieth of it."""
    half = edge.resolution
    digits = next((n for n in range(12) if abs(float(f"{half:.{n}f}") - half) <= 0.05 * half), 12)
    return f"{edge.value:.{digits}f} ± {edge.resolution:.{digits}f}"
