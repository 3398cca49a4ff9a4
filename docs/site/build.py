# SPDX-License-Identifier: Apache-2.0
"""Builds the static site: docs/site/build calls it.

The pages are the Markdown files of the repository as they stand. They are staged in a folder of the same layout, so that their
links to each other hold; files that they link to become pages of their own. The reference is generated: of the API from the
comments of the proto files, of C++ from the public headers by Doxygen, of Python from docstrings, of JavaScript by TypeDoc, of
the command line by the programs. Sphinx makes HTML of it all, and check_links finds what leads nowhere.
"""
import argparse
import os
import pathlib
import shutil
import subprocess
import sys

import api_pages
import check_links
import cpp_pages
import figures
import js_pages
import program_pages
import python_pages
import staging

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
HERE = REPOSITORY / "docs/site"
TOOLS = {"sphinx-build": "python3-sphinx", "doxygen": "doxygen", "protoc": "protobuf-compiler"}


class Missing(Exception):
    """Something that the build needs is not there."""


def program(variable, path):
    """A program of ours that SEGCTL or SEGSERVE names, or that was built before."""
    found = pathlib.Path(os.environ.get(variable, REPOSITORY / path))
    if not os.access(found, os.X_OK):
        raise Missing(f"{found} is not there: it makes figures and the reference. Build it (README.md, \"Install\"), or name "
                      f"another one by {variable}.")
    return found


def build(site, work):
    for tool, package in TOOLS.items():
        if shutil.which(tool) is None:
            raise Missing(f"{tool} is not there: it is in Debian's package {package} (deploy/install-packages site)")
    segctl = program("SEGCTL", "build/release/client/segctl")
    segserve = program("SEGSERVE", "build/release/server/segserve")

    shutil.rmtree(work, ignore_errors=True)
    pages = staging.Pages(REPOSITORY, work)
    pages.generated(api_pages.pages(REPOSITORY))
    pages.generated(cpp_pages.pages(REPOSITORY, work.with_name(work.name + "-doxygen")))
    pages.generated(python_pages.pages(REPOSITORY))
    pages.generated(js_pages.pages(REPOSITORY, work.with_name(work.name + "-js")))
    pages.generated(program_pages.pages(segctl, segserve))
    pages.stage()
    figures.make(REPOSITORY, pages.with_figures(), work, segctl, segserve)

    shutil.rmtree(site, ignore_errors=True)
    made = subprocess.run(["sphinx-build", "-q", "-W", "--keep-going", "-j", "auto", "-b", "html", "-d", f"{work}-doctrees",
                           "-c", HERE, work, site], check=False)
    faults = check_links.faults(site)
    for fault in faults:
        print(f"site: {fault}", file=sys.stderr)
    return made.returncode == 0 and not faults


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("site", type=pathlib.Path)
    site = parser.parse_args().site.absolute()
    try:
        if not build(site, site.with_name(site.name + "-source")):
            sys.exit(1)
    except (Missing, figures.Failed) as error:
        sys.exit(f"site: {error}")
    print(f"The site is in {site}: open {site / 'index.html'} in a browser.")


if __name__ == "__main__":
    main()
