"""Harmonics as users write them: lists of [amplitude, phase]."""

from pipeline.errors import ConfigurationError
from solver import ParameterError
from solver.model.gear_model import harmonic_pairs

__all__ = ["pairs_of"]


def pairs_of(key: str, value) -> list[list[float]]:
    """Pairs of finite numbers; raises ConfigurationError with the key where it is something else."""
    prefix, _, name = key.rpartition(".")
    try:
        return [list(pair) for pair in harmonic_pairs(name, value)]
    except ParameterError as error:
        raise ConfigurationError(f"{prefix}.{error}") from None
