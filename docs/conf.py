"""Configuration of the documentation site: `make docs`."""

import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "docs/_extensions")]

with (ROOT / "pyproject.toml").open("rb") as _file:
    version = release = tomllib.load(_file)["project"]["version"]
project = "bevelmap"
author = copyright = "the bevelmap authors"

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "numpydoc",
    "bevelmap_docs.mathml",
    "bevelmap_docs.generated",
    "bevelmap_docs.gallery",
    "sphinx_gallery.gen_gallery",
    "bevelmap_docs.offline",
]
exclude_patterns = ["_build", "_extensions"]

# Markdown as on GitHub, with formulas; headings are targets of links.
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3
myst_dmath_allow_labels = False

# `name` in a docstring is a link where there is such an object, and plain otherwise.
default_role = "py:obj"
autodoc_typehints = "none"
autodoc_member_order = "bysource"
numpydoc_show_class_members = False
numpydoc_class_members_toctree = False

# Examples are scripts, which ruff formats and any Python runs. They run in the process of this build: kernels are
# loaded once, and there is no notebook server.
bevelmap_examples = str(ROOT / "examples")
sphinx_gallery_conf = {
    "gallery_dirs": "gallery",
    "filename_pattern": r"\.py$",
    "within_subsection_order": "bevelmap_docs.gallery.place",
    "image_scrapers": ("bevelmap_docs.gallery.figures", "matplotlib"),
    "capture_repr": (),
    "run_stale_examples": True,
    "download_all_examples": False,
    "write_computation_times": False,
    "show_signature": False,
}

html_theme = "pydata_sphinx_theme"
html_math_renderer = "mathml"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_title = f"bevelmap {release}"
html_show_sourcelink = False
html_copy_source = False
# Beside the pages of a section stands the list of them; a page without a section has none.
html_sidebars = {page.stem: [] for page in Path(__file__).parent.glob("*.md")}
html_sidebars |= {"*/*": ["sidebar-nav-bs"], "genindex": [], "search": []}
html_theme_options = {
    "navigation_with_keys": False,
    "header_links_before_dropdown": 8,
    "navbar_persistent": ["search-button"],
    "show_toc_level": 2,
    "show_prev_next": True,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": [],
}
