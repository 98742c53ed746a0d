"""The site: `python -m sphinx -W --keep-going docs build/site` (extra `docs`), on a machine without a network too."""

from __future__ import annotations

import sys
from importlib.metadata import version as version_of
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "_ext"))

project = "cogging"
author = "the cogging contributors"
copyright = "the cogging contributors, MIT"
release = version = version_of("cogging")

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.mathjax",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "sphinx_design",
    "site_pages",
]
exclude_patterns = ["README.md", "_generated/*/cards.md"]
nb_execution_mode = "off"  # the notebooks hold what they gave when the tests ran them
myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 4
suppress_warnings = [
    "myst.header",  # an included part of a page may begin below the first level
    "ref.python",  # a word such as "velocity" in a list of attributes, which several classes have, leads nowhere
]

napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_custom_sections = [("Fields", "params_style")]
napoleon_use_rtype = False
autodoc_member_order = "bysource"
autodoc_typehints = "none"  # the signatures have them
default_role = "code"

html_theme = "furo"
html_title = "cogging"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_show_sphinx = False
html_domain_indices = False  # the pages of the Python face list the same
html_copy_source = False
html_theme_options = {"sidebar_hide_name": False, "navigation_with_keys": False}
templates_path = ["_templates"]
_sidebar = ("brand", "search", "scroll-start", "navigation", "scroll-end")  # those of furo
html_sidebars = {"**": [*(f"sidebar/{part}.html" for part in _sidebar), "versions.html"]}
copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True

mathjax_path = "mathjax/tex-svg.js"  # one file, out of the package of extra `docs`: formulas need no network
mathjax3_config = {"svg": {"fontCache": "global"}, "options": {"enableMenu": False}}
