# SPDX-License-Identifier: Apache-2.0
"""Settings of Sphinx for the static site; docs/site/build calls it."""
import pathlib
import re
import shutil
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import mermaid  # noqa: E402

project = "segserve"
author = "The segserve authors"
copyright = author
release = re.search(r"VERSION ([\d.]+)", (HERE.parents[1] / "CMakeLists.txt").read_text().partition("project(")[2])[1]

extensions = ["myst_parser"]
source_suffix = {".md": "markdown"}
myst_heading_anchors = 5
# The files of the repository are read as they stand, and some headings of GitHub's Markdown skip a level.
suppress_warnings = ["myst.header", "misc.highlighting_failure"]
pygments_style, pygments_dark_style = "default", "monokai"

html_theme = "furo"
html_title = "segserve"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sourcelink = False
html_show_sphinx = False


def add_mermaid(app, error):
    """Puts Mermaid beside its pages. Without npm their diagrams stay text."""
    script = mermaid.script()
    if error is None and script is not None:
        shutil.copy(script, pathlib.Path(app.outdir) / "_static" / "mermaid.min.js")
    elif error is None:
        (pathlib.Path(app.outdir) / "_static" / "mermaid.min.js").write_text("// npm was not there when the site was built.\n")


def setup(app):
    app.connect("build-finished", add_mermaid)
