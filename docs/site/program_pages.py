# SPDX-License-Identifier: Apache-2.0
"""The reference of the command line, as the programs themselves tell it."""
import os
import re
import subprocess


def told(program, *arguments):
    environment = os.environ | {"COLUMNS": "110"}
    for name in list(environment):
        if name.startswith(("SEGCTL_", "SEGSERVE_")):
            del environment[name]
    return subprocess.run([program, *arguments], check=True, capture_output=True, text=True, env=environment).stdout.rstrip()


def block(text, language="text"):
    return f"```{language}\n{text}\n```\n"


def subcommands(text):
    """The names in the list of subcommands of a help text."""
    listed = text.partition("ubcommands:\n")[2] or text.partition("ommands:\n")[2]
    return re.findall(r"^  ([a-z]+)\b", listed.partition("\n\n")[0], re.M)


def pages(segctl, segserve):
    overview = told(segctl, "--help")
    parts = ["# segctl\n\n`segctl COMMAND --help` shows the options that most people need, `--help-all` all of them. "
             "Every option stands below.\n", block(overview)]
    for name in subcommands(overview):
        parts.append(f"## segctl {name}\n\n{block(told(segctl, name, '--help-all'))}")
    server = ["# segserve\n\nEach flag is also an environment variable and a key of a TOML file: "
              "[operations](../docs/operations.md#configuration) explains both.\n",
              "## Flags\n", block(told(segserve, "--help")),
              "## Settings with their defaults\n\n`segserve --print-config` writes them as such a file:\n",
              block(told(segserve, "--print-config"), "toml")]
    return {"reference/segctl.md": "\n".join(parts), "reference/segserve.md": "\n".join(server)}
