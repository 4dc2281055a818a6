"""Examples in the docstrings of the pipeline, where no other test runs them."""

import doctest
import importlib

import pytest


@pytest.mark.parametrize(
    "module",
    [
        "pipeline.errors",
        "pipeline.run.workforce",
        "pipeline.run.slurm_settings",
        "pipeline.cli.completion",
        "pipeline.config.places",
        "pipeline.config.secrets",
        "pipeline.config.folders",
        "pipeline.store.listing",
        "pipeline.api",
        "pipeline.opened_plane",
        "pipeline.plane.motions",
    ],
)
def test_doctests_of_the_pipeline(module):
    results = doctest.testmod(importlib.import_module(module))
    assert results.attempted > 0 and results.failed == 0
