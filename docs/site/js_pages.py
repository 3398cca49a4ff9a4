# SPDX-License-Identifier: Apache-2.0
"""The reference of the JavaScript package, from the comments of its sources by TypeDoc (docs/site/js).

Without npm and its registry it is one page that says so.
"""
import hashlib
import os
import pathlib
import shutil
import subprocess

FOLDER = "reference/js"
# What the pages that TypeDoc names by the sources are called, and what stands above them.
PAGES = {
    "index": ("The JavaScript package",
              "This is the reference of the package `segserve` in Node, made from the comments of its sources. "
              "[segserve for JavaScript](../../client/js/README.md) shows how it is installed and used."),
    "web": ("In browsers", "`segserve/web` has what [the package in Node](index.md) has but for streams and `OutageError`, and a client of "
                           "its own."),
}
WITHOUT_NPM = ("npm was not there, or did not reach its registry, when the site was built. The file `index.d.ts` of the package has the "
               "reference, too.")


def installed(name, folder):
    """The folder node_modules with the packages of folder/package-lock.json, in the cache that CMake uses (client/npm_packages.cmake)."""
    lock = folder / "package-lock.json"
    cache = pathlib.Path(os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache") / "segserve"
    target = cache / f"{name}-{hashlib.sha256(lock.read_bytes()).hexdigest()[:12]}"
    if not (target / "complete").exists():
        target.mkdir(parents=True, exist_ok=True)
        for file in (lock, folder / "package.json"):
            shutil.copy(file, target)
        # No package runs a script of its own here.
        subprocess.run(["npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund", "--loglevel=error"], cwd=target, check=True,
                       stdout=subprocess.DEVNULL)
        (target / "complete").touch()
    return target / "node_modules"


def titled(name, text):
    """A page of TypeDoc with our title."""
    title, intro = PAGES[name]
    hidden = "\n\n```{toctree}\n:hidden:\n\n" + "\n".join(other for other in PAGES if other != "index") + "\n```\n"
    return f"# {title}\n\n{intro}\n{text.partition(chr(10))[2]}" + (hidden if name == "index" else "")


def pages(repository, work):
    """`work`: a folder for the package as it is built."""
    package, site = repository / "client/js", repository / "docs/site/js"
    try:
        built_with, modules = installed("js", package), installed("site-js", site)
    except (OSError, subprocess.CalledProcessError):
        return {f"{FOLDER}/index.md": f"# {PAGES['index'][0]}\n\n{WITHOUT_NPM}\n"}
    shutil.rmtree(work, ignore_errors=True)
    subprocess.run(["node", package / "build.js", work, built_with], check=True)
    entries = [word for name in PAGES for word in ("--entryPoints", work / f"build/{name}.ts")]
    # TypeDoc looks for its plugins from where it runs.
    subprocess.run([modules / ".bin/typedoc", "--options", site / "typedoc.json", "--tsconfig", work / "tsconfig.json", *entries,
                    "--out", work / "reference"], cwd=modules.parent, check=True)
    return {f"{FOLDER}/{name}.md": titled(name, (work / f"reference/{name}.md").read_text()) for name in PAGES}
