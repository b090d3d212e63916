# SPDX-License-Identifier: Apache-2.0
"""The site is made of the pages as they lie in the repository: docs/site/build."""

project = "Flat plank"
copyright = "Flat Plank maintainers, Apache-2.0"
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.viewcode"]
root_doc = "docs/site/index"
include_patterns = [
    "README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md", "examples/README.md",
    "docs/**.md", "docs/site/*.rst",
]  # fmt: skip
myst_heading_anchors = 4
myst_enable_extensions = ["dollarmath"]
html_theme = "furo"
html_title = project
html_show_sphinx = False
suppress_warnings = ["myst.header"]

autodoc_typehints = "signature"
autodoc_member_order = "bysource"
# `fp.load` is what a reader types, wherever it is written
add_module_names = False
python_use_unqualified_type_names = True
