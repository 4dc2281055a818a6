"""Repairing a store: only files that its layout names are written or removed.

Metadata and axes are put back, damaged rows are marked as pending, so that a sweep computes exactly their blocks again;
damaged groups are taken out, so that their stages make them again, or of those in blocks what is not sound.
"""

from collections.abc import Collection
from pathlib import Path

from pipeline.store.arrays import row_layouts
from pipeline.store.block_states import write_states
from pipeline.store.damage import Damage
from pipeline.store.durable import write_whole
from pipeline.store.groups import take_away
from pipeline.store.inspection import template_of
from pipeline.store.names import ADDED, IN_BLOCKS, LEFT_OVER, STORE_FILE, files_of
from pipeline.store.removal import remove_file
from pipeline.store.row_groups import set_aside
from pipeline.store.states import PENDING
from pipeline.store.template import consolidate

__all__ = ["remove_left_overs", "repair"]


def repair(path: Path, damage: Collection[Damage]) -> None:
    """Put metadata and axes back, mark damaged rows as pending, take damaged groups away.

    Parameters
    ----------
    path : Path
    damage : collection of Damage
        As `find_damage` gave it.
    """
    files, blocks = {item.file for item in damage}, {item.block for item in damage if item.block is not None}
    groups = {item.group for item in damage}
    plan, template = template_of(path)
    for file in template:
        if file in files:
            write_whole(path / file, template[file])
    for group in ADDED:
        if group in groups and group in IN_BLOCKS:
            set_aside(path, group)
        elif group in groups:
            take_away(path, group)
    # A damaged chunk that is only partly written again would have to be read first.
    places = [plan.place(block) for block in blocks]
    for file in (file for array in row_layouts(plan).values() for place in places for file in array.files(*place)):
        if file in files:
            remove_file(path / file)
    consolidate(path)
    for block in blocks:
        write_states(path, plan, block, PENDING)


def remove_left_overs(path: Path) -> None:
    """Remove what killed processes left half written; the store must be held."""
    for name in files_of(path) if path.exists() else ():
        if LEFT_OVER.fullmatch(name) and STORE_FILE.fullmatch(name):
            (path / name).unlink(missing_ok=True)
