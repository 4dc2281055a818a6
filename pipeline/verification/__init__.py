"""Where a stored map can be trusted: its solutions integrated, its rows swept at higher orders, every cell judged."""

from pipeline.verification.credibility import Credibility
from pipeline.verification.group import StoredVerification, read_verification
from pipeline.verification.running import Summary, tasks_of, verify
from pipeline.verification.sheets import region_lines, write_sheets
from pipeline.verification.starts import read_labels
from pipeline.verification.verdicts import Verdict

__all__ = [
    "Credibility",
    "StoredVerification",
    "Summary",
    "Verdict",
    "read_labels",
    "read_verification",
    "region_lines",
    "tasks_of",
    "verify",
    "write_sheets",
]
