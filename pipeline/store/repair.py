"""Repairing a store: only files that its layout names are written or removed.

Metadata and axes are put back, damaged rows are marked as pending, so that a sweep computes exactly their blocks again;
damaged groups are taken out, so that their stages make them again, or of those in blocks what is not sound.
"""

from collections.abc import Collection

from pipeline.config.places import Place
from pipeline.store.arrays import row_layouts
from pipeline.store.block_states import write_states
from pipeline.store.damage import Damage
from pipeline.store.documents import listed_in
from pipeline.store.files import files_at
from pipeline.store.groups import remove_group
from pipeline.store.inspection import template_of
from pipeline.store.names import ADDED, GROUP_FILE, IN_BLOCKS, LEFT_OVER, METADATA, STORE_FILE
from pipeline.store.row_groups import set_aside
from pipeline.store.states import PENDING
from pipeline.store.template import consolidate

__all__ = ["remove_left_overs", "repair"]


def repair(path: Place, damage: Collection[Damage]) -> None:
    """Put metadata and axes back, mark damaged rows as pending, take damaged groups away.

    Parameters
    ----------
    path : Place
    damage : collection of Damage
        As `find_damage` gave it.
    """
    files, blocks = {item.file for item in damage}, {item.block for item in damage if item.block is not None}
    groups = {item.group for item in damage}
    store = files_at(path)
    plan, template = template_of(store)
    store.write({file: content for file, content in template.items() if file in files})
    # Before anything of them is taken away, they are not listed any more.
    consolidate(path, groups)
    for group in ADDED:
        if group in groups and group in IN_BLOCKS:
            set_aside(path, group)
        elif group in groups:
            remove_group(path, group)
    # A damaged chunk that is only partly written again would have to be read first.
    places = [plan.place(block) for block in blocks]
    for file in (file for array in row_layouts(plan).values() for place in places for file in array.files(*place)):
        if file in files:
            store.remove(file)
    for block in blocks:
        write_states(store, plan, block, PENDING)


def remove_left_overs(path: Place) -> None:
    """Remove what killed processes left half written or half taken away; the store must be held."""
    store = files_at(path)
    if not store.exists():
        return
    names, listed = store.sizes(), listed_in(store)
    for name in names:
        if LEFT_OVER.fullmatch(name) and STORE_FILE.fullmatch(name):
            store.remove(name)
    # Without a list, a group may be whole all the same.
    for group in ADDED if listed else ():
        inside = [name.removeprefix(f"{group}/") for name in names if name.startswith(f"{group}/")]
        half = inside and METADATA not in inside and group not in listed
        if half and all(map(GROUP_FILE.fullmatch, inside)):
            store.vanish(group)
