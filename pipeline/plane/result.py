"""What a map tells, in one sentence."""

import numpy as np

from pipeline.plane.labels import contact_lost, double_sided, jumping
from pipeline.plane.stored import StoredPlane
from solver import domain_label

__all__ = ["result_line"]

#: What happens, and whether it does under a label.
_SAID = (
    ("several motions in {}", jumping),
    ("teeth part in {}", contact_lost),
    ("back flanks struck in {}", double_sided),
)


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
    codes, cells = np.unique(plane.domain, return_counts=True)
    computed = codes != 0
    if not np.any(computed):
        return ""
    labels, shares = [domain_label(int(code)) for code in codes[computed]], cells[computed] / cells[computed].sum()
    whole = "volume" if plane.domain.ndim == 3 else "plane"
    whole = f"the {whole}" if np.all(computed) else f"what is computed of the {whole}"
    words = []
    for text, happens in _SAID:
        share = sum((share for label, share in zip(labels, shares, strict=True) if happens(label)), 0.0)
        words.append(text.format(_percent(float(share))))
    # Of what the others are shares of, the first one speaks for all.
    words[0] += f" of {whole}"
    return f"{len(labels)} domain{'s' * (len(labels) != 1)}; {', '.join(words)}"


def _percent(share: float) -> str:
    """A share as people write it: 0 and 100 are exact, and what is not 0 does not look so.

    Examples
    --------
    >>> _percent(0.0), _percent(0.0004), _percent(0.2607), _percent(1.0)
    ('0 %', '0.1 %', '26.1 %', '100 %')
    """
    if share in (0.0, 1.0):
        return f"{100 * share:.0f} %"
    return f"{min(max(100.0 * share, 0.1), 99.9):.1f} %"
