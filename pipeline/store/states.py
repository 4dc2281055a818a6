"""States of rows, as `status` has them."""

__all__ = ["COMPLETE", "FAILED", "PENDING"]

PENDING, COMPLETE, FAILED = 0, 1, 2
