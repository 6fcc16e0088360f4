"""Settings of the documentation site: `make docs` builds it into build/docs."""

import sys
from pathlib import Path

from erclutch._version import __version__

sys.path.insert(0, str(Path(__file__).parent / "_ext"))

project = "erclutch"
author = "The erclutch authors"
project_copyright = "2026, the erclutch authors; Apache-2.0"
version = release = __version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "cyclopts.ext.sphinx",
    "drawn_math",
    "law_pages",
    "notebook_cells",
    "pictures",
]
exclude_patterns = ["_ext"]
# Attributes of one name stand in several classes: the names in a list of attributes are no links.
suppress_warnings = ["ref.python"]

# Pages.
myst_enable_extensions = ["dollarmath", "colon_fence", "deflist"]
myst_heading_anchors = 3
myst_links_external_new_tab = False
html_math_renderer = "drawn"
# Two hyphens are an option's, no dash.
smartquotes_action = "qe"
# A word in single backticks in a docstring is code.
default_role = "code"

# Reference.
add_module_names = False
autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"
autodoc_class_signature = "mixed"
autodoc_default_options = {"members": True}
napoleon_numpy_docstring = False
napoleon_use_ivar = True

# Look. Furo brings no fonts and asks no server; neither do we.
html_theme = "furo"
html_title = f"erclutch {version}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_js_files = ["site.js"]
html_copy_source = False
html_show_sourcelink = False
# Summaries would be fetched, which a page opened as a file may not do.
html_show_search_summary = False
html_search_scorer = str(
    Path(__file__).parent / "_static" / "scorer.js"
)  # Sphinx looks for it where it was started
html_baseurl = ""
html_theme_options = {
    "light_css_variables": {"color-brand-primary": "#005a8f", "color-brand-content": "#005a8f"},
    "dark_css_variables": {"color-brand-primary": "#7cc4f0", "color-brand-content": "#7cc4f0"},
}
copybutton_exclude = ".linenos, .gp, .go"
pygments_style = "a11y-high-contrast-light"
pygments_dark_style = "a11y-high-contrast-dark"
