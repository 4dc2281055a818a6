"""When a number of ours is said to agree with one of the study."""

__all__ = ["AGREES", "DIFFERS", "NOT_COMPARED", "THRESHOLD_AGREES"]

AGREES, DIFFERS, NOT_COMPARED = "agrees", "differs", "cannot be compared"

#: A threshold agrees with the study's within this share of it.
THRESHOLD_AGREES = 0.05
