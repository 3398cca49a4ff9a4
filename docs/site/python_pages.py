# SPDX-License-Identifier: Apache-2.0
"""The reference of the Python package, from its docstrings. The sources are parsed and not imported."""
import ast
import pathlib
import re
import textwrap

FOLDER = "reference/python"
# What is on which page, in the order in which somebody who writes a program reads. Names that are not here come last.
PAGES = {
    "client": ("Calls", ["Client", "Result", "MergeTree", "Selection", "Candidates", "Prompts", "PromptedPoint", "Placement",
                         "Resolution", "ResultWarning", "SupportPlane", "ServerInfo", "OptionInfo", "Tls", "Retry"]),
    "stream": ("Streams", ["Stream", "StreamOptions", "Outcome", "OutcomeKind", "FrameReport", "WhenBehind", "Order", "Tracking",
                           "Tracks", "TrackEvent"]),
    "clouds": ("Clouds and codecs", ["Cloud", "as_cloud", "View", "Payload", "encode", "pcd_file", "Intrinsics", "encode_rgbd"]),
    "errors": ("Errors", ["Error"]),
}
MODULES = {"aio": ("asyncio", "segserve.aio"), "ros": ("Messages of ROS", "segserve.ros"),
           "local": ("Without a server", "segserve.local")}


def prose(docstring):
    """A docstring as Markdown: what is indented is code, and a line that begins with names of parameters an entry."""
    parts, code = [], []

    def end_code():
        if code:
            parts.append("```python\n" + textwrap.dedent("\n".join(code)).strip("\n") + "\n```")
            code.clear()

    for line in (docstring or "").split("\n"):
        if line.startswith("    ") or (code and not line.strip()):
            code.append(line)
            continue
        end_code()
        text = re.sub(r"([*_<])", r"\\\1", line) if "`" not in line else line
        found = re.match(r"((?:[a-z]+(?:\\_[a-z]+)*)(?:, [a-z]+(?:\\_[a-z]+)*)*): ", text)
        parts.append(f"- **{found[1]}**: {text[found.end():]}" if found else text)
    end_code()
    text = "\n".join(parts)
    text = re.sub(r"(?<!\n)\n(```python)", r"\n\n\1", text)
    return re.sub(r"(?m)^(?!- \*\*)(.+)\n(?=- \*\*)", r"\1\n\n", text).strip()


def documented(node):
    return prose(ast.get_docstring(node))


def signature(node, name):
    """The head of a function, one argument a line if it is long."""
    made = ast.unparse(node.args)
    made = re.sub(r"^(self|cls)(, )?", "", made)
    head = f"{'async ' if isinstance(node, ast.AsyncFunctionDef) else ''}def {name}"
    returns = f" -> {ast.unparse(node.returns)}" if node.returns is not None and name != "__init__" else ""
    if len(head) + len(made) + len(returns) + 2 <= 100:
        return f"{head}({made}){returns}"
    arguments = [ast.unparse(ast.arguments(posonlyargs=[], args=[a], vararg=None, kwonlyargs=[], kw_defaults=[], kwarg=None,
                                           defaults=[])) for a in node.args.args if a.arg not in ("self", "cls")]
    defaults = [None] * (len(arguments) - len(node.args.defaults)) + node.args.defaults
    arguments = [f"{a} = {ast.unparse(d)}" if d is not None else a for a, d in zip(arguments, defaults)]
    arguments += [f"*{node.args.vararg.arg}"] if node.args.vararg else ["*"] if node.args.kwonlyargs else []
    for a, d in zip(node.args.kwonlyargs, node.args.kw_defaults):
        arguments.append(f"{a.arg}: {ast.unparse(a.annotation)}" + (f" = {ast.unparse(d)}" if d is not None else ""))
    arguments += [f"**{node.args.kwarg.arg}"] if node.args.kwarg else []
    return f"{head}(\n    " + ",\n    ".join(arguments) + f",\n){returns}"


def comment_of(lines, node):
    """What is said of a member: above it in lines with #:, or behind it."""
    above, at = [], node.lineno - 2
    while at >= 0 and lines[at].strip().startswith("#:"):
        above.insert(0, lines[at].strip()[2:].strip())
        at -= 1
    behind = re.search(r"\s#\s(.*)$", lines[node.end_lineno - 1])
    return re.sub(r"([*_<|])", r"\\\1", " ".join(above) or (behind[1] if behind else ""))


def is_public(name):
    return not name.startswith("_") or name == "__init__"


def write_class(node, lines, name):
    out = [f"## {name}\n", documented(node) + "\n"]
    bases = [ast.unparse(base) for base in node.bases if ast.unparse(base) not in ("NamedTuple", "enum.Enum", "Exception")]
    if bases:
        out.insert(1, f"It is a {' and a '.join(f'`{base}`' for base in bases)}.\n")
    members = [(item.target.id, ast.unparse(item.annotation) + (f" = {ast.unparse(item.value)}" if item.value is not None and
                                                                "field(" not in ast.unparse(item.value) else ""), item)
               for item in node.body if isinstance(item, ast.AnnAssign) and is_public(item.target.id)]
    members += [(item.targets[0].id, ast.unparse(item.value), item) for item in node.body
                if isinstance(item, ast.Assign) and isinstance(item.targets[0], ast.Name) and is_public(item.targets[0].id)]
    functions = [item for item in node.body if isinstance(item, (ast.FunctionDef, ast.AsyncFunctionDef)) and is_public(item.name)
                 and not any(ast.unparse(mark).endswith(".setter") for mark in item.decorator_list)]
    properties = [item for item in functions if any(ast.unparse(mark) == "property" for mark in item.decorator_list)]
    if members or properties:
        out += ["| member | type and default | meaning |", "| --- | --- | --- |"]
        out += [f"| `{member}` | `{kind.replace('|', chr(92) + '|')}` | {comment_of(lines, item)} |"
                for member, kind, item in members]
        for item in properties:
            kind = ast.unparse(item.returns).replace("|", "\\|") if item.returns is not None else ""
            said = documented(item).replace("\n", " ")
            out.append(f"| `{item.name}` | `{kind}` | {said} |")
        out.append("")
    for item in functions:
        if item in properties or (item.name == "__init__" and not documented(item)):
            continue
        shown = name.split(".")[-1] if item.name == "__init__" else item.name
        out.append(f"```python\n{signature(item, item.name).replace('def __init__', shown)}\n```\n\n{documented(item)}\n")
    return "\n".join(out)


def write_function(node, name):
    return f"## {name}()\n\n```python\n{signature(node, node.name)}\n```\n\n{documented(node)}\n"


class Sources:
    """The modules of the package, parsed."""

    def __init__(self, folder):
        self._folder = folder
        self._parsed = {}

    def module(self, name):
        """(tree, lines) of segserve.x.y."""
        if name not in self._parsed:
            path = self._folder.joinpath(*name.split(".")[1:])
            text = (path / "__init__.py" if path.is_dir() else path.with_suffix(".py")).read_text()
            self._parsed[name] = (ast.parse(text), text.split("\n"))
        return self._parsed[name]

    def exported(self, name):
        """{exported name: module that defines it}."""
        return {alias.asname or alias.name: item.module for item in self.module(name)[0].body if isinstance(item, ast.ImportFrom)
                for alias in item.names if item.module and item.module.startswith("segserve")}

    def written(self, module, name, shown):
        tree, lines = self.module(module)
        for item in tree.body:
            if isinstance(item, ast.ClassDef) and item.name == name:
                return write_class(item, lines, shown)
            if isinstance(item, (ast.FunctionDef, ast.AsyncFunctionDef)) and item.name == name:
                return write_function(item, shown)
        return None


def pages(repository):
    sources = Sources(repository / "client/python/src/segserve")
    exported = sources.exported("segserve")
    placed = {name for _, names in PAGES.values() for name in names}
    rest = [name for name in exported if name not in placed and exported[name] != "segserve"]
    made, rows = {}, []
    for page, (title, names) in PAGES.items():
        names = [*names, *(rest if page == "errors" else [])]
        texts = {name: sources.written(exported[name], name, name) for name in names if name in exported}
        texts = {name: text for name, text in texts.items() if text}
        made[f"{FOLDER}/{page}.md"] = f"# {title}\n\n" + "\n".join(texts.values())
        rows.append(f"| [{title}]({page}.md) | " + ", ".join(f"`{name}`" for name in texts) + " |")
    for page, (title, module) in MODULES.items():
        tree, _ = sources.module(module)
        names = sources.exported(module) if page == "aio" else {
            item.name: module for item in tree.body if isinstance(item, ast.FunctionDef) and is_public(item.name)}
        texts = {name: sources.written(where, name, f"{page}.{name}") for name, where in names.items()}
        made[f"{FOLDER}/{page}.md"] = f"# {title}\n\n{documented(tree)}\n\n" + "\n".join(text for text in texts.values() if text)
        rows.append(f"| [{title}]({page}.md) | " + ", ".join(f"`{page}.{name}`" for name in texts) + " |")
    made[f"{FOLDER}/index.md"] = (
        "# The Python package\n\nThis is the reference of the package `segserve`, made from its docstrings. "
        "[segserve for Python](../../client/python/README.md) shows how it is installed and used.\n\n"
        "| page | has |\n| --- | --- |\n" + "\n".join(rows) +
        "\n\n```{toctree}\n:hidden:\n\n" + "\n".join((*PAGES, *MODULES)) + "\n```\n")
    return made


if __name__ == "__main__":
    for path, text in pages(pathlib.Path(__file__).resolve().parents[2]).items():
        print(f"=== {path}\n{text}")
