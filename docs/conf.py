"""The site of the documentation: `make docs` builds it into out/site.

Its sources are the Markdown files of the repository where they lie, so that the same links work
here and where the repository is read; Sphinx starts from the repository's root for that reason.
"""

import sys
import tomllib
from pathlib import Path

from pygments.lexers.special import TextLexer
from sphinx.highlighting import lexers

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(Path(__file__).parent / "extensions")]

project = "tendon_mj"
author = "the tendon_mj developers"
copyright = "the tendon_mj developers, Apache-2.0"

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "command_help",
    "default_names",
    "docstrings",
    "equations",
    "name_tables",
    "pictures",
    "search_words",
    "start_page",
]

root_doc = "docs/index"
include_patterns = [
    "README.md",
    "CHANGELOG.md",
    "docs/*.md",
    "docs/api/*.md",
    "models/README.md",
    "models/*/README.md",
    "experiments/*/*.md",
]
exclude_patterns = [".*", "out", "dist", "tests", "tendon_mj", "**/__pycache__"]

# every reference is resolved, but those to types of other packages: nothing is fetched
nitpicky = True
nitpick_ignore_regex = [(r"py:.*", r".*")]

myst_enable_extensions = ["dollarmath", "html_image"]
myst_heading_anchors = 4  # as on GitHub
suppress_warnings = ["myst.header"]  # some pages begin with a picture

autosummary_generate = False  # a page has many names
autodoc_member_order = "bysource"
autodoc_typehints_format = "short"
python_maximum_signature_line_length = 80

lexers["csv"] = TextLexer()  # tables are shown as they are

metadata = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
html_theme = "furo"
html_title = "tendon_mj"
html_favicon = html_logo = "static/icon.svg"
html_theme_options = {
    "source_repository": metadata["project"]["urls"]["Source"],
    "source_branch": "main",
    "source_directory": "",
    "top_of_page_buttons": ["view"],
    "dark_css_variables": {"color-background-primary": "#0D1117"},  # that of the dark pictures
}
html_search_scorer = str(Path(__file__).with_name("search_scores.js"))
html_math_renderer = "mathtext"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_show_sourcelink = False
html_copy_source = False
