"""What a store was made with against what is asked for, by the keys that a user types."""

from collections.abc import Iterator, Mapping

from pipeline.config.compose import Settings
from pipeline.errors import shown
from pipeline.plan.axes import ROLES
from pipeline.plan.kinds import BEVEL, KINDS, kind_of
from pipeline.plan.plan import Plan
from pipeline.plan.planning import asked_numbers

__all__ = ["by_key", "differences", "of_typed"]

_MOST_NAMED = 5
#: Letters of a value.
_LONGEST = 120
_NOTHING = "nothing"
_ENDS = {"low": "min", "high": "max"}


def by_key(numbers: Mapping) -> dict[str, object]:
    """What `Plan.inputs` holds, by the keys of the configuration.

    Examples
    --------
    >>> by_key({"gear": {"b": 1.0, "variation_rotation": 0.0}, "sweep": {"name": "omega", "low": 0.1}})
    {'gear.b': 1.0, 'gear.variation.rotation': 0.0, 'plane.sweep.name': 'omega', 'plane.sweep.min': 0.1}
    """
    physical, kind = numbers.get("physical"), KINDS[numbers.get("kind", BEVEL.name)]
    found = {}
    for name, value in numbers.items():
        if name in ROLES:
            found |= {f"plane.{name}.{_ENDS.get(part, part)}": one for part, one in (value or {}).items()}
        elif name == "gear":
            # Of a bevel pair in physical units they follow from these.
            if not (physical and kind is BEVEL):
                matrices = value.get("matrices", {})
                found |= {kind.key(key): one for key, one in (value | matrices).items() if key != "matrices"}
        elif name == "physical":
            found |= _flat((value or {}).get("gear", {}), "gear.physical")
            found |= _flat((value or {}).get("mesh_cycle") or {}, "gear.physical.mesh_cycle")
            # The numbers that they give are among the gear's.
            found |= {"gear.physical.tooth": teeth["method"]} if (teeth := (value or {}).get("teeth")) else {}
        elif name == "thermal":
            found |= _flat(value or {}, "gear.thermal")
        elif name == "kind":
            found |= {} if kind is BEVEL else {"gear": value}
        elif name == "omega":
            found["plane.omega"] = value
        elif name == "solver":
            found |= _flat(value, "solver")
        else:
            found[f"store.{name}"] = value
    return found


def _flat(value, key: str) -> dict[str, object]:
    if not isinstance(value, Mapping):
        return {key: value}
    return {name: leaf for child in value for name, leaf in _flat(value[child], f"{key}.{child}").items()}


def differences(stored: Mapping, asked: Mapping) -> str:
    """The keys whose values differ, with both values; empty where none does.

    Examples
    --------
    >>> differences({"gear.b": 1.0, "plane.omega": None}, {"gear.b": 0.5, "plane.omega": None})
    'gear.b: stored 1.0, asked 0.5'
    """
    stored, asked = _in_the_same_units(stored, asked)
    keys = [key for key in sorted(stored.keys() | asked.keys()) if stored.get(key) != asked.get(key)]
    words = [f"{key}: stored {_shown(stored, key)}, asked {_shown(asked, key)}" for key in keys[:_MOST_NAMED]]
    return "; ".join([*words, *([f"and {len(keys) - _MOST_NAMED} more"] if len(keys) > _MOST_NAMED else [])])


def _in_the_same_units(*both: Mapping) -> Iterator[Mapping]:
    """The same, unless the gears are of two kinds, or one is dimensionless and the other is not: then that is all there
    is to say of them."""
    kinds = [values.get("gear", BEVEL.name) for values in both]
    physical = [any(key.startswith("gear.physical.") for key in values) for values in both]
    for values, kind, given in zip(both, kinds, physical, strict=True):
        others = {key: value for key, value in values.items() if not key.startswith("gear.")}
        if len(set(kinds)) > 1:
            yield {**others, "gear": kind}
        elif len(set(physical)) > 1:
            yield {**others, "gear.physical": "given" if given else None}
        else:
            yield values


def _shown(values: Mapping, key: str) -> object:
    value = values.get(key)
    return _NOTHING if value is None else value if isinstance(value, int | float) else shown(str(value), _LONGEST)


def of_typed(settings: Settings, plan: Plan) -> str:
    """In what a stored plan differs from what the user typed; empty where everything typed holds for it.

    What was not typed is as the store has it: a stage that reads a store needs no more than its name.

    Parameters
    ----------
    settings : Settings
    plan : Plan
        Of the store.

    Raises
    ------
    ConfigurationError
        If what was typed is not allowed at all.
    """
    if not any(map(settings.overridden, ("gear", "plane", "solver", "store", "quality"))):
        return ""
    asked, stored = by_key(asked_numbers(settings)), by_key(plan.inputs)
    axes = {kind_of(plan).key(axis.name) for axis in plan.axes}
    stored, asked = _in_the_same_units(stored, asked)
    keys = [key for key in asked.keys() | stored.keys() if _asks_for(settings, key, axes)]
    return differences(*({key: values[key] for key in keys if key in values} for values in (stored, asked)))


def _asks_for(settings: Settings, key: str, axes: set[str]) -> bool:
    """Whether the user said what a key should be, by itself or by choosing a file that says so."""
    if settings.typed(key):
        return True
    section = key.split(".")[0]
    if key in ("plane.sweep.num", "plane.parameter.num"):
        # Planes take them from the quality.
        return settings.chosen("quality") or settings.typed(f"quality.{key.split('.')[1]}")
    # What an axis replaces is none of the gear's.
    return section != "store" and settings.chosen(section) and key not in axes
