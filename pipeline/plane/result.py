"""What a map tells, in one sentence."""

from dataclasses import dataclass

import numpy as np

from pipeline.errors import counted
from pipeline.plane.labels import contact_lost, double_sided, jumping
from pipeline.plane.stored import StoredPlane
from solver import domain_label

__all__ = ["MapSummary", "map_summary", "result_line", "share_percent"]

#: What happens: as `MapSummary` names it, in words, and whether it does under a label.
_HAPPENS = (
    ("several_motions", "several motions in {}", jumping),
    ("teeth_part", "teeth part in {}", contact_lost),
    ("back_flanks_struck", "back flanks struck in {}", double_sided),
)


@dataclass(frozen=True)
class MapSummary:
    """A map in numbers; shares are of its computed cells.

    Parameters
    ----------
    domains : int
        Number of labels.
    several_motions, teeth_part, back_flanks_struck : float
        Share of the cells in which several stable motions coexist, a stable motion parts the teeth, one strikes both
        flanks.
    whole : bool
        Whether all cells are computed.
    """

    domains: int
    several_motions: float
    teeth_part: float
    back_flanks_struck: float
    whole: bool


def map_summary(plane: StoredPlane) -> MapSummary | None:
    """What the map of a stored plane or volume tells; None where nothing has been computed."""
    codes, cells = np.unique(plane.domain, return_counts=True)
    computed = codes != 0
    if not np.any(computed):
        return None
    labels, shares = [domain_label(int(code)) for code in codes[computed]], cells[computed] / cells[computed].sum()
    found = {
        name: float(sum((share for label, share in zip(labels, shares, strict=True) if happens(label)), 0.0))
        for name, _, happens in _HAPPENS
    }
    return MapSummary(domains=len(labels), whole=bool(np.all(computed)), **found)


def result_line(plane: StoredPlane) -> str:
    """Number of domains of a stored plane or volume, and the shares of its computed cells in which something happens.

    Parameters
    ----------
    plane : StoredPlane
        Or a volume.

    Returns
    -------
    str
        Empty where nothing has been computed.
    """
    summary = map_summary(plane)
    if summary is None:
        return ""
    whole = "plane" if plane.plan.parameter2 is None else "volume"
    whole = f"the {whole}" if summary.whole else f"what is computed of the {whole}"
    words = [text.format(share_percent(getattr(summary, name))) for name, text, _ in _HAPPENS]
    # Of what the others are shares of, the first one speaks for all.
    words[0] += f" of {whole}"
    return f"{counted(summary.domains, 'domain')}; {', '.join(words)}"


def share_percent(share: float) -> str:
    """A share as people write it: 0 and 100 are exact, and what is not 0 does not look so.

    Examples
    --------
    >>> share_percent(0.0), share_percent(0.0004), share_percent(0.2607), share_percent(1.0)
    ('0 %', '0.1 %', '26.1 %', '100 %')
    """
    if not 0.0 < share < 1.0:
        return f"{100.0 * share:.0f} %"
    return f"{min(max(100.0 * share, 0.1), 99.9):.1f} %"
