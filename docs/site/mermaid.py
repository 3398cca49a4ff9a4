# SPDX-License-Identifier: Apache-2.0
"""Diagrams in Mermaid, drawn in the browser by a copy of Mermaid in the site."""
import html as html_module
import os
import pathlib
import shutil
import subprocess

VERSION = "11.4.1"


def script():
    """Mermaid's script, which npm installs once into the cache folder; None without npm."""
    cache = pathlib.Path(os.environ.get("XDG_CACHE_HOME", pathlib.Path.home() / ".cache")) / "segserve"
    folder = cache / f"mermaid-{VERSION}"
    found = folder / "node_modules/mermaid/dist/mermaid.min.js"
    if not found.exists() and shutil.which("npm") is not None:
        folder.mkdir(parents=True, exist_ok=True)
        subprocess.run(["npm", "install", "--prefix", folder, "--no-audit", "--no-fund", "--no-package-lock", "--ignore-scripts",
                        "--loglevel=error", f"mermaid@{VERSION}"], check=True, stdout=subprocess.DEVNULL)
    return found if found.exists() else None


def html(diagram, static):
    """A diagram as a block of raw HTML. `static` leads to the static files of the site."""
    return ("```{raw} html\n"
            f'<pre class="mermaid">\n{html_module.escape(diagram)}</pre>\n'
            f'<script src="{static}/mermaid.min.js"></script>\n'
            f'<script src="{static}/diagrams.js"></script>\n'
            "```")
