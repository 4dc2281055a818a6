"""The command line as text: `--help` as it is printed, and the stages of the registry as a table."""

from pipeline.cli.help import usage
from pipeline.stages import STAGES

__all__ = ["stages", "usage_text"]


def stages() -> str:
    """Every stage in the order of a run, as a table."""
    lines = ["| `stages=[…]` | what it does | writes to the store | works on volumes |", "|" + " --- |" * 4]
    for entry in STAGES:
        stage = entry.load()
        yes_or_no = [("no", "yes")[flag] for flag in (stage.writes, stage.of_volumes)]
        if entry.several_planes:
            yes_or_no[1] = "reads several planes"
        lines.append(f"| `{entry.name}` | {entry.sentence} | {' | '.join(yes_or_no)} |")
    return "\n".join(lines)


def usage_text() -> str:
    """What `python -m pipeline --help` prints."""
    return f"```text\n{usage()}```"
