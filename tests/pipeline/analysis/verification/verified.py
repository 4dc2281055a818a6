"""Small planes verified in this process: with few samples of few periods, and nobody watching."""

import dataclasses

from pipeline.config.compose import compose
from pipeline.run.workforce import Workforce
from tests.pipeline.planes import cluster

RUN = Workforce(cluster("none")).run


def silent(done, failed):
    """Progress that nobody watches."""


def settings(**changes):
    """Settings of the verification, small where they cost time."""
    values = {"samples": 30, "beside": 4, "max_periods": 1500, "columns": 25}
    return dataclasses.replace(compose([]).config.verify, **{**values, **changes})
