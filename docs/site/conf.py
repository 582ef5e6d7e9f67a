"""Sphinx's configuration of the documentation site; scripts/make-docs.sh brings the sources together."""

import os

project = "prehend"
version = release = os.environ.get("PREHEND_VERSION", "")
extensions = ["myst_parser", "sphinx.ext.autodoc"]
html_theme = "furo"
html_title = "prehend"
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
root_doc = "index"
exclude_patterns = ["site"]
# Headings are linked to as on code hosts: page.md#a-heading.
myst_heading_anchors = 4
myst_enable_extensions = ["colon_fence"]
autodoc_member_order = "bysource"
autodoc_typehints = "none"
pygments_style = "friendly"
pygments_dark_style = "monokai"
# Words of a lexer's own that blocks do not always keep to.
suppress_warnings = ["misc.highlighting_failure"]
