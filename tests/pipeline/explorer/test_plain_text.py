"""Mathematical text of figures on a page without typesetting: every parameter of every kind of system."""

import pytest

from pipeline.explorer.plain_text import plain
from pipeline.figures.naming import gear_text, symbol
from pipeline.plan.kinds import KINDS
from tests.pipeline.planes import small_plan


@pytest.mark.parametrize("kind", KINDS)
def test_every_axis_has_a_symbol_that_a_page_can_show(kind):
    for name in ("omega", *KINDS[kind].axes):
        assert not set(plain(symbol(name))) & set("\\${}")


@pytest.mark.parametrize("gear", ["published", "spur", "rotor", "stop"])
def test_the_head_of_a_figure_can_be_shown(gear):
    plane = "omega_fe" if gear == "published" else "omega_gap"
    assert not set(plain(gear_text(small_plan(f"gear={gear}", f"plane={plane}")))) & set("\\${}")
