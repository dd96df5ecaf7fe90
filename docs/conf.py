"""The documentation site: `make docs`."""

import os
import sys
from importlib.metadata import version as version_of
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE / "_ext")]

project = "flexident"
author = "the flexident developers"
release = version = version_of("flexident")
extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.viewcode",
    "sphinx_click",
    "plain_docstrings",
    "public_names",
    "generated_reference",
    "measured_data",
]
exclude_patterns = ["_build", "_ext"]

html_theme = "furo"
html_title = "flexident"
html_theme_options = {"navigation_with_keys": True}
html_static_path: list[str] = []

myst_enable_extensions = ["attrs_block", "colon_fence", "deflist", "dollarmath", "substitution"]
myst_heading_anchors = 3

# Tutorials run when the site is built; an error in one fails the build.
nb_execution_mode = os.environ.get("DOCS_EXECUTION", "cache")
nb_execution_cache_path = str(HERE.parent / "out" / "docs-cache")
nb_execution_timeout = 900
nb_execution_raise_on_error = True
nb_merge_streams = True

autodoc_member_order = "bysource"
autodoc_typehints = "none"  # signatures carry them as written
autodoc_default_options = {"members": True}
python_use_unqualified_type_names = True

nitpicky = True
