"""The store of a plane: a zarr group whose template is written first and filled block by block.

Only the task that owns a block writes its chunks, `status` last, so that a block is either complete or computed again.

Names are loaded when they are first used: what a store says of itself is read without zarr, which takes long to import.
"""

import importlib

_HOMES = {
    "attributes": ("axis_attributes", "flags", "label_flags"),
    "blocks": ("RowValues", "kept_rows", "pending_blocks", "read_rows", "row_values", "write_block"),
    "identity": ("check", "exists", "read_layout", "read_plan", "refuse_foreign", "store_path"),
    "inspection": ("damage_error", "find_damage"),
    "outcomes": ("failures", "notes", "proven_cells", "statuses"),
    "states": ("COMPLETE", "FAILED", "PENDING"),
    "template": ("consolidate", "create"),
}
_HOME_OF = {name: f"{__name__}.{module}" for module, names in _HOMES.items() for name in names}

__all__ = sorted(_HOME_OF)


def __getattr__(name: str):
    if name not in _HOME_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = globals()[name] = getattr(importlib.import_module(_HOME_OF[name]), name)
    return value


def __dir__():
    return sorted({*globals(), *__all__})
