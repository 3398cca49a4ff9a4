# SPDX-License-Identifier: Apache-2.0
"""The reference of the API segserve.v1, from the comments of its proto files."""
import pathlib
import re
import subprocess
import tempfile

from google.protobuf import descriptor_pb2

FOLDER = "reference/api"
PACKAGE = ".segserve.v1."
Field = descriptor_pb2.FieldDescriptorProto
# The order in which somebody who writes a client reads.
ORDER = ["segmentation_service", "cloud", "options", "result", "segment", "stream", "error_reason", "server_info", "prompts",
         "tracking", "block"]


def described(repository):
    """The files of the package, with their comments."""
    protos = sorted((repository / "proto/segserve/v1").glob("*.proto"))
    with tempfile.TemporaryDirectory() as work:
        out = pathlib.Path(work) / "api.pb"
        subprocess.run(["protoc", "-I", repository / "proto", "-I", "/usr/share/grpc-proto", "--include_source_info",
                        f"--descriptor_set_out={out}", *protos], check=True)
        return descriptor_pb2.FileDescriptorSet.FromString(out.read_bytes()).file


def prose(comment):
    """A comment as Markdown: what looks like a drawing or a table in it stays as it is, and names are code."""
    paragraphs = []
    for paragraph in re.split(r"\n\s*\n", re.sub(r"^ ", "", comment.rstrip().strip("\n"), flags=re.M)):
        lines = paragraph.split("\n")
        if all(line.startswith("  ") for line in lines):
            paragraphs.append("```text\n" + paragraph + "\n```")
        else:
            text = "\n".join(lines)
            text = text.replace("*", r"\*").replace("<", r"\<").replace("_", r"\_") if "`" not in text else text
            paragraphs.append(re.sub(r":\n- ", ":\n\n- ", text))
    return "\n\n".join(paragraphs)


class Reference:
    def __init__(self, files):
        self._files = files
        self._page = {}  # of each type, by its full name
        for file in files:
            for item in (*file.message_type, *file.enum_type):
                self._page[f"{PACKAGE}{item.name}"] = (self.stem(file), item.name)
                for inner in getattr(item, "nested_type", ()):
                    self._page[f"{PACKAGE}{item.name}.{inner.name}"] = (self.stem(file), f"{item.name}.{inner.name}")
                for inner in item.enum_type if hasattr(item, "enum_type") else ():
                    self._page[f"{PACKAGE}{item.name}.{inner.name}"] = (self.stem(file), f"{item.name}.{inner.name}")

    @staticmethod
    def stem(file):
        return pathlib.PurePosixPath(file.name).stem

    def link(self, type_name):
        if type_name not in self._page:
            return f"`{type_name.lstrip('.')}`"
        page, name = self._page[type_name]
        return f"[{name}]({page}.md#{name.lower().replace('.', '')})"

    def type_of(self, field):
        if field.type in (Field.TYPE_MESSAGE, Field.TYPE_ENUM):
            name = self.link(field.type_name)
        else:
            name = f"`{Field.Type.Name(field.type).removeprefix('TYPE_').lower()}`"
        if field.label == Field.LABEL_REPEATED:
            return f"repeated {name}"
        return f"optional {name}" if field.proto3_optional else name

    def page(self, file):
        comments = {tuple(place.path): place for place in file.source_code_info.location}

        def comment(*path):
            place = comments.get(path)
            if place is None:
                return ""
            return prose("\n\n".join(text for text in (place.leading_comments, place.trailing_comments) if text.strip()))

        out = [f"# {self.stem(file)}.proto\n"]
        for place in file.source_code_info.location:  # what is said of the file as a whole
            out += [prose(text) + "\n" for text in place.leading_detached_comments if "SPDX" not in text]
        for s, service in enumerate(file.service):
            out += [f"## {service.name}\n", comment(6, s) + "\n"]
            for m, method in enumerate(service.method):
                request = ("stream of " if method.client_streaming else "") + self.link(method.input_type)
                answer = ("stream of " if method.server_streaming else "") + self.link(method.output_type)
                out += [f"### {method.name}\n", f"{request} → {answer}\n", comment(6, s, 2, m) + "\n"]
        items = [(comments[(4, i)].span[0], self._message, message, (4, i)) for i, message in enumerate(file.message_type)]
        items += [(comments[(5, i)].span[0], self._enum, enum, (5, i)) for i, enum in enumerate(file.enum_type)]
        for _, write, item, path in sorted(items, key=lambda row: row[0]):
            out += write(item, item.name, path, comment, "##")
        return "\n".join(out)

    def _message(self, message, name, path, comment, level):
        out = [f"{level} {name}\n", comment(*path) + "\n"]
        for f, field in enumerate(message.field):
            member = ""
            if field.HasField("oneof_index") and not field.proto3_optional:
                oneof = message.oneof_decl[field.oneof_index].name
                member = f", one of `{oneof}`"
                is_first = all(other.oneof_index != field.oneof_index or not other.HasField("oneof_index")
                               for other in message.field[:f])
                about = comment(*path, 8, field.oneof_index)
                if is_first and about:
                    out.append(f"**{oneof}**: {about}\n")
            text = comment(*path, 2, f).replace("\n", "\n  ")
            out.append(f"- `{field.name}` = {field.number}, {self.type_of(field)}{member}\n" + (f"\n  {text}\n" if text else ""))
        for n, nested in enumerate(message.nested_type):
            out += self._message(nested, f"{name}.{nested.name}", (*path, 3, n), comment, "###")
        for e, enum in enumerate(message.enum_type):
            out += self._enum(enum, f"{name}.{enum.name}", (*path, 4, e), comment, "###")
        return out

    @staticmethod
    def _enum(enum, name, path, comment, level):
        out = [f"{level} {name}\n", comment(*path) + "\n"]
        for v, value in enumerate(enum.value):
            text = comment(*path, 2, v).replace("\n", "\n  ")
            out.append(f"- `{value.name}` = {value.number}\n" + (f"\n  {text}\n" if text else ""))
        return out

    def index(self, stems):
        rows = []
        for stem in stems:
            file = next(f for f in self._files if self.stem(f) == stem)
            names = [*(s.name for s in file.service), *(m.name for m in file.message_type), *(e.name for e in file.enum_type)]
            links = ", ".join(f"[{name}]({stem}.md#{name.lower()})" for name in names)
            rows.append(f"| [{stem}.proto]({stem}.md) | {links} |")
        return ("# The API segserve.v1\n\n"
                "This is the whole interface of a server, made from the comments of the proto files. "
                "It is frozen ([decision 10](../../docs/decisions/0010-frozen-api.md)): a client that is written today works with "
                "every later server of version 1. A first client needs [Segment](segmentation_service.md#segment) alone; "
                "[stream.proto](stream.md) tells the rules of streams.\n\n"
                "| file | has |\n| --- | --- |\n" + "\n".join(rows) +
                "\n\n```{toctree}\n:hidden:\n\n" + "\n".join(f"{stem} <{stem}>" for stem in stems) + "\n```\n")


def pages(repository):
    files = described(repository)
    reference = Reference(files)
    stems = sorted((reference.stem(file) for file in files), key=lambda stem: (ORDER.index(stem) if stem in ORDER else 99, stem))
    made = {f"{FOLDER}/{reference.stem(file)}.md": reference.page(file) for file in files}
    made[f"{FOLDER}/index.md"] = reference.index(stems)
    return made
