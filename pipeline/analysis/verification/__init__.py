"""Where a stored map can be trusted: its solutions integrated, its rows swept at higher orders, every cell judged."""

from pipeline.analysis.verification.credibility import Credibility
from pipeline.analysis.verification.group import StoredVerification, read_verification
from pipeline.analysis.verification.running import Summary, tasks_of, verify
from pipeline.analysis.verification.sheets import region_lines, write_sheets
from pipeline.analysis.verification.verdicts import Verdict

__all__ = [
    "Credibility",
    "StoredVerification",
    "Summary",
    "Verdict",
    "read_verification",
    "region_lines",
    "tasks_of",
    "verify",
    "write_sheets",
]
