"""Settings of the documentation site: `make docs` builds it, a warning is an error."""

import builtins
import sys
from importlib import metadata
from pathlib import Path
from typing import Any

from sphinx_gallery.scrapers import figure_rst

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "examples")]

project = "brushgrip"
author = "brushgrip contributors"
release = metadata.version("brushgrip")
extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "sphinx_gallery.gen_gallery",
]
exclude_patterns = ["_build", "gallery/*.ipynb", "gallery/*.py", "gallery/*.json"]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
myst_enable_extensions = ["deflist"]
myst_heading_anchors = 4
# Single backticks in docstrings are names and expressions in fixed width.
default_role = "code"
# The gallery's settings hold functions.
suppress_warnings = ["config.cache"]
autodoc_typehints = "description"
# Else what a dataclass documents as its attributes is listed as parameters once more.
autodoc_typehints_description_target = "documented"
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True, "show-inheritance": True}
napoleon_use_ivar = True
GALLERY = [
    "change_of_surface",
    "estimate_in_a_loop",
    "find_the_missing_effect",
    "free_decay",
    "least_steering",
    "live_session",
    "observability",
    "own_effect",
    "own_observer",
    "own_reader",
    "towing",
    "trade_offs",
]
"""Examples that need nothing but the checkout and end in a minute or so; each is run for its page."""
DRAWING = [
    *("change_of_surface", "free_decay", "least_steering", "live_session"),
    *("observability", "towing", "trade_offs"),
]
"""Those that draw a picture where one is named."""


def arguments(_: object, variables: dict[str, str]) -> list[str]:
    """The picture that an example is asked for."""
    name = Path(variables["src_file"]).stem
    return [f"{name}.png"] if name in DRAWING else []


def pictures(_: object, variables: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Moves the picture that an example has drawn onto its page."""
    source = Path(variables["src_file"])
    drawn = source.with_suffix(".png")
    if not drawn.exists():
        return ""
    target = next(variables["image_path_iterator"])
    drawn.rename(target)
    return figure_rst([target], gallery_conf["src_dir"])


def name_the_script(_: object, name: str) -> None:
    """Scripts find their recordings beside themselves; the gallery gives them no `__file__`."""
    builtins.__file__ = str(ROOT / "examples" / Path(name).name)  # type: ignore[attr-defined]


sphinx_gallery_conf = {
    "reset_modules": (name_the_script,),
    "examples_dirs": str(ROOT / "examples"),
    "gallery_dirs": "gallery",
    "filename_pattern": rf"/({'|'.join(GALLERY)})\.py",
    "ignore_pattern": "|".join(
        rf"^{p.stem}\.py" for p in sorted((ROOT / "examples").glob("*.py")) if p.stem not in GALLERY
    ),
    "image_scrapers": (pictures,),
    "reset_argv": arguments,
    "show_memory": False,
    "download_all_examples": False,
    "within_subsection_order": "FileNameSortKey",
    "abort_on_example_error": True,
}
html_theme = "pydata_sphinx_theme"
html_title = "brushgrip"
html_static_path = ["_static"]
html_css_files = ["wide.css"]
html_theme_options = {
    "show_prev_next": False,
    "navigation_depth": 2,
    # An example has no sections to list beside it; its output needs the width.
    "secondary_sidebar_items": {
        **{f"gallery/{name}": [] for name in GALLERY},
        "index": [],
        "**": ["page-toc"],
    },
}
