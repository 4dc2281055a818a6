"""The study's published numbers, each recomputed from stored planes."""

from pipeline.statements.evaluation import Evaluated, evaluate, evaluate_all
from pipeline.statements.planes import Planes
from pipeline.statements.published import STATEMENTS
from pipeline.statements.statement import Statement

__all__ = ["STATEMENTS", "Evaluated", "Planes", "Statement", "evaluate", "evaluate_all"]
