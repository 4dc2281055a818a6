"""The store of a plane: a zarr group whose template is written first and filled block by block.

Only the task that owns a block writes its chunks, `status` last, so that a block is either complete or computed again.
"""

from pipeline.store.attributes import axis_attributes, flags, label_flags
from pipeline.store.blocks import RowValues, kept_rows, pending_blocks, read_rows, row_values, write_block
from pipeline.store.identity import check, read_layout, read_plan, refuse_foreign, store_path
from pipeline.store.inspection import damage_error, find_damage
from pipeline.store.repair import remove_left_overs, repair
from pipeline.store.states import COMPLETE, FAILED, PENDING, failures, notes, proven_cells, statuses
from pipeline.store.template import consolidate, create

__all__ = [
    "COMPLETE",
    "FAILED",
    "PENDING",
    "RowValues",
    "axis_attributes",
    "check",
    "consolidate",
    "create",
    "damage_error",
    "failures",
    "find_damage",
    "flags",
    "kept_rows",
    "label_flags",
    "notes",
    "pending_blocks",
    "proven_cells",
    "read_layout",
    "read_plan",
    "read_rows",
    "refuse_foreign",
    "remove_left_overs",
    "repair",
    "row_values",
    "statuses",
    "store_path",
    "write_block",
]
