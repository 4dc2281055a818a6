"""How measured things read in a cell: intervals, shares, shifts, edges; one wording for every format for readers."""

from pipeline.study.numerals import percent, signed
from pipeline.study.tables.bands import BandAtResonance
from pipeline.study.tables.edges import band_edges
from solver import ImpactState
from solver.regions.bands import Line

__all__ = ["changes", "impact_states", "jump_size", "jumps", "labels", "peak_shift", "ranges"]

NONE = "none"


def ranges(parts) -> str:
    """Ranges of the row parameter to four digits, or a dash."""
    return "; ".join(f"{low:.4g}–{high:.4g}" for low, high in parts) or "–"


def jumps(band: BandAtResonance) -> str:
    """Multivalued intervals at the first and the last value, and the envelope of all lines where it says more."""
    first, last = _intervals(band, band.first), _intervals(band, band.last)
    if not band.jump_height:
        return NONE
    text = first if first == last else f"{first} to {last}"
    envelope = "{:.4f}–{:.4f}".format(*band.envelope)
    return text if text == envelope else f"{text}; all within {envelope}"


def _intervals(band: BandAtResonance, line: Line) -> str:
    return " and ".join(f"{low:.4f}–{high:.4f}" for low, high in band.jumps(line)) or NONE


def jump_size(band: BandAtResonance) -> str:
    """Share of the band's height with a jump, and the widest interval."""
    if not band.jump_height:
        return NONE
    widest = max(band.widths)
    height = "" if len(band.lines) == 1 else f"in {percent(band.jump_height)} of the band; "
    several = f", up to {band.intervals_per_line} at once" if band.intervals_per_line > 1 else ""
    return f"{height}{widest * band.resonance.natural:.4f} ({percent(widest)}){several}"


def impact_states(band: BandAtResonance) -> str:
    """Impact states of stable motions with their shares of the region."""
    shares = ((state, band.state_share(state)) for state in ImpactState)
    return ", ".join(f"{state.symbol}: {percent(share)}" for state, share in shares if share > 0.0)


def labels(band: BandAtResonance) -> str:
    """n/I labels of the region with their shares, the largest first."""
    shares = sorted(band.region.shares.items(), key=lambda item: -item[1])
    return ", ".join(f"{label} {percent(share)}" for label, share in shares)


def peak_shift(band: BandAtResonance) -> str:
    """Shift of the peak in percent from the first to the last row that has one, its range, and rows without a peak."""
    shifts = [100.0 * row.shift for row in band.with_peak]
    if not shifts:
        return _without_peak(band)
    first, last, low, high = (signed(value) for value in (shifts[0], shifts[-1], min(shifts), max(shifts)))
    text = f"{first} %" if first == last else f"{first} to {last} %"
    # A range that only rounding sets apart from the two ends says nothing.
    if min(shifts) < min(shifts[0], shifts[-1]) - 0.1 or max(shifts) > max(shifts[0], shifts[-1]) + 0.1:
        text += f"; range {low} to {high} %"
    return f"{text}; {_without_peak(band)}" if len(shifts) < len(band.peaks) else text


def _without_peak(band: BandAtResonance) -> str:
    """How many rows have no peak, and in how many of them it may lie above the amplitude ceiling."""
    missing = [row for row in band.peaks if row.peak is None]
    if not band.peaks:
        return "no complete row"
    unbounded = sum(row.open for row in missing)
    above = f", {unbounded} of them open above the amplitude ceiling" if unbounded else ""
    return f"no peak in {len(missing)} of {len(band.peaks)} rows{above}"


def changes(band: BandAtResonance, sign: str) -> str:
    """Where jumps, loss of contact and double-sided impact appear or end in the parameter."""
    where = {"inside": "", "below": ", below the band", "above": ", above the band"}
    parts = [
        f"{what} {'from' if edge.appears else 'up to'} {sign} = {edge.value:.4g}{where[edge.place]}"
        for what, found in band.edges.items()
        for edge in band_edges(found, band.region.low, band.region.high)
    ]
    return "; ".join(parts) or NONE
