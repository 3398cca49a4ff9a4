# SPDX-License-Identifier: Apache-2.0
"""Packages of npm that tests use as other people's implementations."""
import os
import pathlib
import subprocess


def installed(name, packages):
    """The folder node_modules with the packages, which npm installs once in the cache folder. `packages`: name ->
    version."""
    cache = pathlib.Path(os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache") / "segserve"
    folder = cache / "-".join([name, *packages.values()])
    if not (folder / "complete").exists():
        folder.mkdir(parents=True, exist_ok=True)
        command = ["npm", "install", "--prefix", str(folder), "--no-audit", "--no-fund", "--no-package-lock",
                   "--loglevel=error", *(f"{package}@{version}" for package, version in packages.items())]
        done = subprocess.run(command, capture_output=True, timeout=280)
        if done.returncode != 0:
            raise RuntimeError(f"{command}: {done.stdout.decode()} {done.stderr.decode()}")
        (folder / "complete").touch()
    return folder / "node_modules"
