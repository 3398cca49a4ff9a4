# SPDX-License-Identifier: Apache-2.0
"""Copies the pages of the repository to a folder that Sphinx reads, and the files that they link to."""
import pathlib
import posixpath
import re
import subprocess

import mermaid

PICTURES = (".png", ".jpg", ".svg")
LANGUAGES = {".hpp": "cpp", ".cpp": "cpp", ".proto": "protobuf", ".py": "python", ".js": "javascript", ".mjs": "javascript",
             ".ts": "typescript", ".yaml": "yaml", ".yml": "yaml", ".toml": "toml", ".json": "json", ".cmake": "cmake",
             ".sh": "bash", ".txt": "text"}
# Pages of GitHub alone.
NOT_PAGES = (".github/", "docs/site/")
# These folders and files have better pages than their text.
INSTEAD = {"proto/segserve/v1": "reference/api/index.md", "docs/site": None}

FENCE = re.compile(r"^(?P<fence> *```+)(?P<language>\{\w+\}|[\w-]*)(?P<note>[^\n`]*)\n(?P<content>.*?)^(?P=fence)[ ]*$", re.M | re.S)
LINK = re.compile(r"(?P<before>\]\()(?P<target>[^)\s]+)(?P<after>\))")
FIGURE = re.compile(r"\]\(figures/[\w.-]+\)")


def language_of(path):
    """How Pygments calls the language of a file."""
    if path.name == "CMakeLists.txt":
        return "cmake"
    if path.name.startswith("Dockerfile"):
        return "docker"
    if path.suffix:
        return LANGUAGES.get(path.suffix, "text")
    first = path.read_text(errors="replace").partition("\n")[0]
    return "python" if "python" in first else "bash" if first.startswith("#!") else "text"


class Pages:
    """The pages of the site, by their paths in the repository."""

    def __init__(self, repository, work):
        self._repository, self._work = repository, work
        listed = subprocess.run(["git", "ls-files", "-co", "--exclude-standard"], cwd=repository, check=True,
                                capture_output=True, text=True).stdout.splitlines()
        self._files = {name for name in listed if (repository / name).is_file()}
        self._documents = {name for name in self._files if name.endswith(".md") and not name.startswith(NOT_PAGES)}
        self._generated = {}
        self._wanted = []  # files and folders that pages link to

    def generated(self, pages):
        """Adds pages that have no file: {path: Markdown}."""
        self._generated.update(pages)

    def with_figures(self):
        """The pages that show figures."""
        return [pathlib.Path(name) for name in sorted(self._documents)
                if FIGURE.search((self._repository / name).read_text())]

    def stage(self):
        index = (self._repository / "docs/site/index.md").read_text()
        decisions = sorted(name for name in self._documents if re.match(r"docs/decisions/\d", name))
        for name in sorted(self._documents):
            text = self._page(name, (self._repository / name).read_text())
            if name == "docs/decisions/README.md":
                entries = "\n".join(posixpath.basename(page) for page in decisions)
                text += f"\n```{{toctree}}\n:hidden:\n\n{entries}\n```\n"
            elif name.removesuffix(".md") not in index and name not in decisions:
                text = f"---\norphan: true\n---\n{text}"
            self._write(name, text)
        for name, text in sorted(self._generated.items()):
            self._write(name, self._page(name, text))
        self._write("index.md", self._page("index.md", index))
        done = set()
        while self._wanted:
            name = self._wanted.pop()
            if name not in done:
                done.add(name)
                self._write_source(name)

    def _write(self, name, text):
        path = self._work / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)

    def _page(self, name, text):
        """The text of a page as Sphinx wants it."""
        kept = []  # code, in which nothing is a link

        def keep(fence):
            content = fence["content"]
            if fence["language"] == "mermaid":
                kept.append(mermaid.html(content, posixpath.relpath("_static", posixpath.dirname(name) or ".")))
            else:
                kept.append(f"{fence['fence']}{fence['language'] or 'text'}\n{content}{fence['fence'].rstrip()}")
            return f"\0{len(kept) - 1}\0"

        text = FENCE.sub(keep, text)
        text = LINK.sub(lambda link: f"]({self._target(name, link['target'])})", text)
        return re.sub(r"\0(\d+)\0", lambda mark: kept[int(mark[1])], text)

    def _target(self, page, target):
        """Where a link of a page leads in the site."""
        address, mark, anchor = target.partition("#")
        if re.match(r"[a-z]+:", target) or not address or address.startswith("figures/"):
            return target
        folder = posixpath.dirname(page)
        found = posixpath.normpath(posixpath.join(folder, address))
        return posixpath.relpath(self._page_of(found), folder or ".") + mark + anchor

    def _page_of(self, found):
        """The page or picture that stands for a file or folder of the repository."""
        if found in self._documents or found in self._generated:
            return found
        if found in INSTEAD and INSTEAD[found]:
            return INSTEAD[found]
        instead = f"reference/api/{posixpath.basename(found).removesuffix('.proto')}.md"
        if found.startswith("proto/segserve/v1/") and instead in self._generated:
            return instead
        if found in self._files:
            if found.endswith(PICTURES):
                (self._work / found).parent.mkdir(parents=True, exist_ok=True)
                (self._work / found).write_bytes((self._repository / found).read_bytes())
                return found
            self._wanted.append(found)
            return f"{found}.md"
        if f"{found}/README.md" in self._documents:
            return f"{found}/README.md"
        if any(name.startswith(f"{found}/") for name in self._files):
            self._wanted.append(found)
            return f"{found}/files.md"
        return found  # It leads nowhere, and the build says so.

    def _write_source(self, name):
        """A page with the text of a file, or with the list of a folder."""
        if name in self._files:
            path = self._repository / name
            text = path.read_text(errors="replace")
            fence = "`" * max(4, 1 + max((len(run) for run in re.findall(r"`+", text)), default=0))
            self._write(f"{name}.md", f"---\norphan: true\n---\n# {posixpath.basename(name)}\n\n`{name}`\n\n"
                                      f"{fence}{language_of(path)}\n{text.rstrip()}\n{fence}\n")
            return
        inside = sorted({f[len(name) + 1:].split("/")[0] for f in self._files if f.startswith(f"{name}/")})
        rows = []
        for entry in inside:
            page = self._page_of(f"{name}/{entry}")
            rows.append(f"- [{entry}]({posixpath.relpath(page, name)})")
        self._write(f"{name}/files.md", f"---\norphan: true\n---\n# {name}\n\n" + "\n".join(rows) + "\n")
