"""A system of one's own: its matrices from the configuration or from files, as plain numbers."""

import math
from dataclasses import fields
from pathlib import Path

import numpy as np

from pipeline.config.gear_schema import System
from pipeline.config.harmonics import pairs_of
from pipeline.config.matrix_files import MOST_DEGREES, numbers_of, read_matrix, read_npz
from pipeline.config.number_files import NumbersError
from pipeline.errors import ConfigurationError, refused, shown

__all__ = ["system_numbers"]

#: Shape of each array of a system of n coordinates; None is any number of rows.
_ARRAYS = {
    "mass": ("n", "n"),
    "damping": ("n", "n"),
    "stiffness": ("n", "n"),
    "contact": ("n",),
    "force": ("n",),
    "varying_force": ("n",),
    "load": (None, "n"),
    "inertial_load": (None, "n"),
}
_NEEDED = ("mass", "damping", "stiffness", "contact", "force")
_COMPLEX = ("load", "inertial_load")
_GAPS = ("front_gap", "back_gap")


def system_numbers(config: System) -> tuple[dict, None]:
    """Numbers of a system of one's own, its arrays among them: what a plan was made from is in it, wherever the files
    are now.

    Raises
    ------
    ConfigurationError
        Naming the key, its value and what is allowed.
    """
    names = [field.name for field in fields(config) if field.name in (*_ARRAYS, *_GAPS)]
    arrays, file = {}, {}
    if config.file is not None:
        try:
            file = read_npz(config.file)
        except NumbersError as error:
            raise ConfigurationError(f"gear.system.file = {shown(config.file)!r} is not allowed: {error}") from None
        if foreign := sorted(set(file) - set(names)):
            raise ConfigurationError(
                f"gear.system.file = {shown(config.file)!r} is not allowed: it must hold {', '.join(names)} and "
                f"nothing else, and has {shown(foreign[0])!r}"
            )
    for name in names:
        value = getattr(config, name)
        if value is not None and name in file:
            raise ConfigurationError(
                f"gear.system.{name} is not allowed: it must be null, because gear.system.file has it"
            )
        if name in file:
            arrays[name] = file[name]
        elif value is not None:
            arrays[name] = _array(name, value)
    for name in (*_NEEDED, "front_gap"):
        if name not in arrays:
            raise ConfigurationError(f"gear.system.{name} has no value: a matrix, a file of one, or gear.system.file")
    n = arrays["contact"].size
    if not 1 <= n <= MOST_DEGREES:
        raise ConfigurationError(
            f"gear.system.contact = {n} numbers is not allowed: it must be from 1 to {MOST_DEGREES}"
        )
    numbers = {name: _listed(name, array, n) for name, array in arrays.items() if name in _ARRAYS}
    if "varying_force" not in arrays:
        for name in ("alpha", "alpha_harmonics"):
            if value := getattr(config, name):
                raise refused(
                    f"gear.system.{name}",
                    value,
                    f"{0.0 if name == 'alpha' else '[]'} unless gear.system.varying_force says where it acts",
                )
    front, back = (_gap(name, arrays[name]) if name in arrays else None for name in _GAPS)
    back = front if back is None else back
    return {
        "matrices": numbers,
        "front_gap": front,
        "back_gap": None if back == math.inf else back,
        "back_stiffness": config.back_stiffness,
        "contact_dashpot": config.contact_dashpot,
        "alpha": config.alpha,
        "alpha_phase": config.alpha_phase,
        "alpha_harmonics": pairs_of("gear.system.alpha_harmonics", config.alpha_harmonics),
        "contact_damping": config.contact_damping,
    }, None


def _array(name: str, value) -> np.ndarray:
    """An array from a list, or from the file that a text names."""
    try:
        if isinstance(value, str):
            return read_npz(value)[name] if Path(value).suffix == ".npz" else read_matrix(value)
        return np.array(value) if name in _GAPS else numbers_of(value)
    except NumbersError as error:
        raise ConfigurationError(f"gear.system.{name} = {shown(str(value))!r} is not allowed: {error}") from None
    except KeyError:
        raise ConfigurationError(
            f"gear.system.{name} = {shown(value)!r} is not allowed: it must hold an array {name!r}"
        ) from None


def _listed(name: str, array: np.ndarray, n: int) -> list:
    """An array of a system of n coordinates as lists; of complex ones [real, imaginary] pairs."""
    shape = tuple(n if size == "n" else size for size in _ARRAYS[name])
    if len(shape) == 2 and array.ndim < 2:
        # A matrix of one row or column looks like a vector in a file.
        array = array.reshape(-1, n) if array.size % n == 0 else array
    elif len(shape) == 1 and array.ndim == 2 and 1 in array.shape:
        array = array.ravel()
    if array.ndim != len(shape) or any(have != want for have, want in zip(array.shape, shape, strict=True) if want):
        wanted = " x ".join("any number" if size is None else str(size) for size in shape)
        have = " x ".join(map(str, array.shape)) or "one number"
        raise ConfigurationError(
            f"gear.system.{name} = {have} is not allowed: it must be {wanted}, because contact has {n}"
        )
    if name in _COMPLEX:
        return np.stack([array.real, np.imag(array)], axis=-1).tolist()
    if np.iscomplexobj(array) and np.any(array.imag):
        raise ConfigurationError(f"gear.system.{name} is not allowed: it must hold real numbers")
    return array.real.astype(float).tolist()


def _gap(name: str, array: np.ndarray) -> float:
    value = float(array.real.ravel()[0]) if array.size == 1 and array.dtype.kind in "iufc" else math.nan
    if math.isnan(value) or (math.isinf(value) and (name == "front_gap" or value < 0.0)):
        allowed = "a finite number" if name == "front_gap" else "a number, or inf for a one-sided contact"
        said = shown(str(array.tolist()))
        raise ConfigurationError(f"gear.system.{name} = {said} is not allowed: it must be {allowed}")
    return value
