"""The whole state of the explorer's view as plain data: an address, and checked when it is read back.

Everything that a page sends goes through `state_of`: it is numbers within the plane's own ranges and words of fixed
lists, or it is refused. Nothing of it names a file or is run.
"""

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from urllib.parse import parse_qsl, quote, urlencode

from pipeline.errors import ConfigurationError, shown
from pipeline.explorer.fixed_parameters import changed_plan, fixed_parameters
from pipeline.plan.axes import Axis
from pipeline.plan.plan import Plan

__all__ = ["Allowed", "ViewState", "allowed_of", "query_of", "state_of"]

Pair = tuple[float, float]

#: A view is named by at most so many characters; how far initial states may lie.
_LONGEST, _FARTHEST = 2000, 1e4
_MOTION = re.compile(r"[A-P]|[1-9][0-9]{0,2}")


@dataclass(frozen=True)
class ViewState:
    """What a view shows.

    Parameters
    ----------
    layer : str
        Of the map.
    at, pin : (x, p) or None
        The place that was clicked, and the one that is kept beside it.
    fixed : tuple of (name, value)
        Fixed parameters that are not as in the plane, by name.
    motion : str or None
        The motion at the place that is shown in time: the letter of an attractor, or the number of the motion of the
        map that integration starts from; None: the first attractor.
    start : (lambda, lambda') or None
        The initial state that it starts from instead.
    basins : bool
        Whether a slice of the basins is shown.
    design : (x, p) or None
        The design point.
    tolerances : (float, float)
        Of the design point, plus or minus, on either axis.
    window : (x low, x high, p low, p high) or None
        The part of the map that is in sight; None: all.
    physical : bool
        Whether values are in physical units.
    """

    layer: str = "domains"
    at: Pair | None = None
    pin: Pair | None = None
    fixed: tuple[tuple[str, float], ...] = ()
    motion: str | None = None
    start: Pair | None = None
    basins: bool = False
    design: Pair | None = None
    tolerances: Pair = (0.0, 0.0)
    window: tuple[float, float, float, float] | None = None
    physical: bool = False


@dataclass(frozen=True)
class Allowed:
    """What a view of one plane may show.

    Parameters
    ----------
    sweep, parameter : Axis
    layers : tuple of str
    fixed : dict of str to (low, high)
    physical : bool
        Whether the gear is one in physical units.
    change : callable
        change(fixed) raises ConfigurationError where the values do not go together.
    """

    sweep: Axis
    parameter: Axis
    layers: tuple[str, ...]
    fixed: dict[str, Pair]
    physical: bool
    change: Callable[[Mapping[str, float]], object] = lambda fixed: None


def allowed_of(plan: Plan, layers: tuple[str, ...]) -> Allowed:
    """What views of a plane may show."""
    fixed = {one.name: (one.low, one.high) for one in fixed_parameters(plan)}
    return Allowed(
        plan.sweep, plan.parameter, layers, fixed, plan.physical is not None, lambda given: changed_plan(plan, given)
    )


def query_of(state: ViewState) -> str:
    """The state as the query of an address; what is as usual is left out, so that the usual state is empty.

    Examples
    --------
    >>> query_of(ViewState(layer="dynamic", at=(0.6, 0.2), fixed=(("b", 0.5),)))
    'layer=dynamic&at=0.6,0.2&b=0.5'
    """
    usual = _texts(ViewState())
    parts = {key: text for key, text in _texts(state).items() if text is not None and text != usual.get(key)}
    return urlencode(parts, safe=",", quote_via=quote)


def _texts(state: ViewState) -> dict[str, str | None]:
    """Key of an address -> its text, None where there is none."""
    return {
        "layer": state.layer,
        "at": _text(state.at),
        "pin": _text(state.pin),
        **{name: repr(float(value)) for name, value in state.fixed},
        "motion": state.motion,
        "start": _text(state.start),
        "basins": "1" if state.basins else None,
        "design": _text(state.design),
        "tolerances": _text(state.tolerances),
        "window": _text(state.window),
        "units": "physical" if state.physical else None,
    }


def state_of(query: str, allowed: Allowed) -> ViewState:
    """The state that the query of an address names.

    Parameters
    ----------
    query : str
        With or without the question mark; may be anything.
    allowed : Allowed

    Raises
    ------
    ConfigurationError
        One line that names what is not allowed.
    """
    query = query.removeprefix("?")
    if len(query) > _LONGEST:
        raise _refused("view", f"{query[:60]}…", f"at most {_LONGEST} characters")
    pairs = parse_qsl(query, keep_blank_values=True)
    given = dict(pairs)
    if len(given) < len(pairs):
        raise _refused("view", query, "each key once")
    sweep, parameter = allowed.sweep, allowed.parameter
    axes = (_Range.of(sweep), _Range.of(parameter))
    read = {
        "layer": lambda text: _word("layer", text, allowed.layers),
        "at": lambda text: _numbers("at", text, axes),
        "pin": lambda text: _numbers("pin", text, axes),
        "motion": _motion,
        "start": lambda text: _numbers("start", text, (_Range("lambda", -_FARTHEST, _FARTHEST),) * 2),
        "basins": lambda text: _word("basins", text, ("0", "1")) == "1",
        "design": lambda text: _numbers("design", text, axes),
        "tolerances": lambda text: _numbers("tolerances", text, (_Range.half(sweep), _Range.half(parameter))),
        "window": lambda text: _window(text, (axes[0], axes[0], axes[1], axes[1])),
        "units": lambda text: _word("units", text, _units(allowed)) == "physical",
    }
    values, fixed = {}, {}
    for key, text in given.items():
        if key in allowed.fixed:
            (fixed[key],) = _numbers(key, text, (_Range(key, *allowed.fixed[key]),))
        elif key in read:
            values["physical" if key == "units" else key] = read[key](text)
        else:
            keys = ", ".join([*read, *allowed.fixed])
            raise ConfigurationError(f"view: {shown(key)!r} is not allowed: it must be one of {keys}")
    if values.get("motion") is not None and values.get("start") is not None:
        raise _refused("start", given["start"], "left out where motion is given")
    allowed.change(fixed)
    return ViewState(fixed=tuple(sorted(fixed.items())), **values)


@dataclass(frozen=True)
class _Range:
    name: str
    low: float
    high: float

    @classmethod
    def of(cls, axis: Axis) -> "_Range":
        return cls(axis.name, axis.low, axis.high)

    @classmethod
    def half(cls, axis: Axis) -> "_Range":
        """Of tolerances."""
        return cls(axis.name, 0.0, 0.5 * (axis.high - axis.low))


def _units(allowed: Allowed) -> tuple[str, ...]:
    return ("dimensionless", "physical") if allowed.physical else ("dimensionless",)


def _text(numbers: tuple[float, ...] | None) -> str | None:
    return None if numbers is None else ",".join(repr(float(number)) for number in numbers)


def _numbers(key: str, text: str, ranges: tuple[_Range, ...]) -> tuple[float, ...]:
    """So many numbers within ranges, by commas."""
    words = text.split(",")
    sentence = ", ".join(f"{one.name} from {one.low:g} to {one.high:g}" for one in ranges)
    if len(words) != len(ranges):
        raise _refused(key, text, sentence)
    found = []
    for word, one in zip(words, ranges, strict=True):
        try:
            number = float(word)
        except ValueError:
            raise _refused(key, text, sentence) from None
        if not (math.isfinite(number) and one.low <= number <= one.high):
            raise _refused(key, text, sentence)
        # No sign of a zero, and no other way of writing a number, makes another state.
        found.append(number + 0.0)
    return tuple(found)


def _window(text: str, ranges: tuple[_Range, ...]) -> tuple[float, ...]:
    found = _numbers("window", text, ranges)
    if not (found[0] < found[1] and found[2] < found[3]):
        raise _refused("window", text, "low below high")
    return found


def _motion(text: str) -> str:
    if not _MOTION.fullmatch(text):
        raise _refused("motion", text, "the letter of an attractor, or the number of a motion from 1")
    return text


def _word(key: str, text: str, words: tuple[str, ...]) -> str:
    if text not in words:
        raise _refused(key, text, f"one of {', '.join(words)}")
    return text


def _refused(key: str, text: str, sentence: str) -> ConfigurationError:
    return ConfigurationError(f"view: {key} = {shown(text)} is not allowed: it must be {sentence}")
