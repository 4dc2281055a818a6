"""The study's published numbers, each recomputed from stored planes."""

from pipeline.study.statements.evaluation import Evaluated, evaluate, evaluate_all
from pipeline.study.statements.planes import Planes
from pipeline.study.statements.published import STATEMENTS
from pipeline.study.statements.statement import Statement

__all__ = ["STATEMENTS", "Evaluated", "Planes", "Statement", "evaluate", "evaluate_all"]
