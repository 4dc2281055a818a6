"""The store of a plane: a zarr group whose template is written first and filled block by block.

Only the task that owns a block writes its chunks, `status` last, so that a block is either complete or computed again.
"""

from pipeline.store.attributes import axis_attributes, flags, label_flags
from pipeline.store.blocks import RowValues, read_rows, row_values, write_block
from pipeline.store.due import certified_rows, kept_rows, pending_blocks, rows_to_certify
from pipeline.store.identity import check, read_layout, read_plan, refuse_foreign
from pipeline.store.inspection import damage_error, find_damage
from pipeline.store.repair import remove_left_overs, repair
from pipeline.store.states import COMPLETE, FAILED, PENDING, failures, statuses
from pipeline.store.template import consolidate, create

__all__ = [
    "COMPLETE",
    "FAILED",
    "PENDING",
    "RowValues",
    "axis_attributes",
    "certified_rows",
    "check",
    "consolidate",
    "create",
    "damage_error",
    "failures",
    "find_damage",
    "flags",
    "kept_rows",
    "label_flags",
    "pending_blocks",
    "read_layout",
    "read_plan",
    "read_rows",
    "refuse_foreign",
    "remove_left_overs",
    "repair",
    "row_values",
    "rows_to_certify",
    "statuses",
    "write_block",
]
