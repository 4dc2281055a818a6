"""The gallery: examples/ is run as the site is built, and each page shows what it prints and draws."""

import shutil
import tempfile
from pathlib import Path

from matplotlib.figure import Figure
from sphinx.application import Sphinx
from sphinx.config import Config
from sphinx_gallery.scrapers import figure_rst

__all__ = ["ORDER", "figures", "place", "setup"]

#: From the first map to what few need.
ORDER = (
    "first_map",
    "article",
    "gear_from_drawing",
    "choose_backlash",
    "spur_pair",
    "finite_elements",
    "cluster",
    "ask_stores",
)


def place(name: str) -> int:
    """Where a file stands in the gallery.

    Raises
    ------
    ValueError
        If `ORDER` does not have it.
    """
    return ORDER.index(Path(name).stem)


def figures(block: tuple, block_vars: dict, gallery_conf: dict) -> str:
    """The figure that the last line of a block is, as a notebook would show it: ours are not in pyplot's list."""
    names = block_vars["fake_main"].__dict__
    shown = names.get("___")
    if not isinstance(shown, Figure) or not hasattr(shown, "_repr_png_"):
        return ""
    names["___"] = None
    path = Path(next(block_vars["image_path_iterator"]))
    path.write_bytes(shown._repr_png_())
    return figure_rst([path], gallery_conf["src_dir"])


def setup(app: Sphinx) -> dict:
    """The examples run in a copy of their own, in which they leave their stores; after the build it is gone."""
    copy = tempfile.TemporaryDirectory(prefix="bevelmap-examples-")

    def prepare(app: Sphinx, config: Config) -> None:
        shutil.copytree(config.bevelmap_examples, copy.name, dirs_exist_ok=True)
        config.sphinx_gallery_conf["examples_dirs"] = copy.name

    app.add_config_value("bevelmap_examples", None, "env", [str])
    # Before sphinx-gallery reads its settings, and after everything is written.
    app.connect("config-inited", prepare, priority=1)
    app.connect("build-finished", lambda app, error: copy.cleanup(), priority=900)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
