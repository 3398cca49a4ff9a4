# SPDX-License-Identifier: Apache-2.0
"""Makes the figures of pages by the commands that stand in them."""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

sys.path.append(str(pathlib.Path(__file__).resolve().parents[2] / "test/e2e"))

import documents  # noqa: E402


class Failed(Exception):
    """A command of a page has failed, or has not made what the page shows."""


SHOWN = re.compile(r"\]\((figures/[\w.-]+)\)")


def commands_of(text):
    """The commands of a page that are run."""
    return [command for block in documents.blocks(text) if block.language == "sh" and not block.not_run
            for command in documents.commands(block.content)]


class Programs:
    """A folder in which the commands of a page are run, with segctl and with servers on free ports."""

    def __init__(self, folder, segctl, segserve):
        self._folder = pathlib.Path(folder)
        programs = self._folder / "bin"
        programs.mkdir()
        (programs / "segctl").symlink_to(pathlib.Path(segctl).absolute())
        (programs / "segserve").symlink_to(pathlib.Path(segserve).absolute())
        self._environment = os.environ | {"PATH": f"{programs}:{os.environ['PATH']}"}
        self._servers = []

    def run(self, page, commands):
        for command in commands:
            if command.endswith("&"):
                self._start(page, command.rstrip("& "))
                continue
            done = subprocess.run(["bash", "-euo", "pipefail", "-c", command], cwd=self._folder, env=self._environment,
                                  check=False, capture_output=True, text=True)
            if done.returncode != 0:
                raise Failed(f"{page}: {command}: {done.stderr}")

    def _start(self, page, command):
        """Starts a server on a free port, which segctl is told by the environment."""
        port = self._folder / f"port{len(self._servers)}"
        server = subprocess.Popen(["bash", "-c", f"exec {command} --listen 127.0.0.1:0 --port-file {port}"], cwd=self._folder,
                                  env=self._environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self._servers.append(server)
        deadline = time.monotonic() + 60
        while not port.exists():
            if server.poll() is not None or time.monotonic() > deadline:
                raise Failed(f"{page}: {command}: the server does not serve")
            time.sleep(0.05)
        self._environment["SEGCTL_SERVER"] = f"127.0.0.1:{port.read_text().strip()}"

    def stop(self):
        for server in self._servers:
            server.terminate()
            server.wait(timeout=60)


def make(repository, pages, site, segctl, segserve):
    """Makes the figures that pages show. A page whose commands write to figures/ makes them for all pages of its folder."""
    for page in pages:
        commands = commands_of((repository / page).read_text())
        if not any("figures/" in command for command in commands):
            continue
        with tempfile.TemporaryDirectory(prefix="segserve-figures-") as work:
            programs = Programs(work, segctl, segserve)
            try:
                programs.run(page, commands)
            finally:
                programs.stop()
            shutil.copytree(pathlib.Path(work) / "figures", site / page.parent / "figures", dirs_exist_ok=True)
    for page in pages:
        for name in SHOWN.findall((repository / page).read_text()):
            if not (site / page.parent / name).exists():
                raise Failed(f"{page} shows {name}, which no command makes")
