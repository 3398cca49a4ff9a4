# SPDX-License-Identifier: Apache-2.0
"""The reference of the public C++ headers, from what Doxygen reads in them."""
import collections
import pathlib
import re
import shutil
import subprocess
import xml.etree.ElementTree as ElementTree

FOLDER = "reference/cpp"
ROOTS = {"core/include": "Segmentation in the same process: `segserve::core`",
         "client/include": "Segmentation through a server: `segserve::client`",
         "proto/include": "Types that both share",
         "core/pcl_adapter/include": "Clouds of PCL: `segserve::pcl`",
         "client/pcl/include": "Clouds of PCL through a server: `segserve::pcl_client`"}


def read_headers(repository, work):
    """Doxygen's XML: [root element of each compound]."""
    shutil.rmtree(work, ignore_errors=True)
    settings = (repository / "docs/Doxyfile").read_text() + f"""
OUTPUT_DIRECTORY = {work}
INPUT = {' '.join(ROOTS)}
USE_MDFILE_AS_MAINPAGE =
STRIP_FROM_PATH = {' '.join(ROOTS)}
AUTOLINK_SUPPORT = NO
WARN_IF_UNDOCUMENTED = NO
GENERATE_HTML = NO
GENERATE_XML = YES
XML_PROGRAMLISTING = NO
"""
    work.mkdir(parents=True)
    subprocess.run(["doxygen", "-"], input=settings, text=True, cwd=repository, check=True, capture_output=True)
    return [ElementTree.parse(path).getroot().find("compounddef") for path in sorted((work / "xml").glob("*.xml"))
            if path.name not in ("index.xml", "Doxyfile.xml")]


def plain(element):
    text = re.sub(r"\s+", " ", "".join(element.itertext())).strip() if element is not None else ""
    return tidy(re.sub(r"< (.*) >", r"<\1>", text).replace(" >", ">") if "< " in text else text)


def inline(element):
    """The text of a paragraph as Markdown."""
    text = escaped(element.text or "")
    for child in element:
        if child.tag == "computeroutput":
            text += f"`{''.join(child.itertext())}`"
        elif child.tag in ("verbatim", "programlisting", "preformatted"):
            text += f"\n\n```text\n{code_of(child)}\n```\n\n"
        elif child.tag in ("itemizedlist", "orderedlist"):
            text += "\n\n" + "".join(f"- {' '.join(inline(p).strip() for p in item.findall('para'))}\n"
                                     for item in child.findall("listitem")) + "\n"
        elif child.tag == "linebreak":
            text += "\n"
        else:
            text += inline(child)
        text += escaped(child.tail or "")
    return text


def code_of(element):
    if element.tag == "programlisting":
        lines = []
        for line in element.findall("codeline"):
            words = "".join((part.text or "") if part.tag != "sp" else " " for part in line.iter())
            lines.append(words)
        return "\n".join(lines)
    return "".join(element.itertext()).strip("\n")


def escaped(text):
    return re.sub(r"([*_<\[\]|`$])", r"\\\1", text)


def description(element, names=("briefdescription", "detaileddescription")):
    return "\n\n".join(inline(paragraph).strip() for name in names if element.find(name) is not None
                       for paragraph in element.find(name).findall("para"))


def cell(text):
    return re.sub(r"\s+", " ", text)


def signature(member):
    """The declaration of a function, variable or type."""
    kind, name = member.get("kind"), member.findtext("name")
    kind_of_type, initial = plain(member.find("type")), plain(member.find("initializer"))
    template = member.find("templateparamlist")
    head = ""
    if template is not None:
        head = "template <" + ", ".join(" ".join(filter(None, (plain(p.find("type")), plain(p.find("declname")))))
                                        for p in template.findall("param")) + ">\n"
    if kind == "function":
        static = "static " if member.get("static") == "yes" else ""
        return f"{head}{static}{kind_of_type + ' ' if kind_of_type else ''}{name}{tidy(member.findtext('argsstring') or '')};"
    if kind == "typedef":
        return tidy(member.findtext("definition") or "") + ";"
    return f"{head}{kind_of_type} {name}{' ' + initial if initial else ''};"


def tidy(text):
    return re.sub(r"\s*=\s*default$", " = default", text.replace(" &", "&").replace(" *", "*").replace("& ", "& "))


def line_of(element):
    return int(element.find("location").get("line"))


def file_of(element):
    place = element.find("location")
    return place.get("file") if place is not None else ""


def heading(name):
    return f"## {name}\n"


def write_enum(member):
    rows = [f"| `{value.findtext('name')}` | {cell(description(value))} |" for value in member.findall("enumvalue")]
    return "\n".join([heading(f"enum {member.findtext('name')}"), description(member) + "\n", "| value | meaning |",
                      "| --- | --- |", *rows, ""])


def write_members(compound):
    """The public members of a class: variables as a table, functions one by one."""
    variables, functions, types = [], [], []
    for section in compound.findall("sectiondef"):
        for member in section.findall("memberdef"):
            if member.get("prot") == "public":
                {"variable": variables, "function": functions}.get(member.get("kind"), types).append(member)
    out = []
    if variables:
        out += ["| member | type and default | meaning |", "| --- | --- | --- |"]
        for member in variables:
            initial = plain(member.find("initializer"))
            kind = plain(member.find("type")).replace("|", r"\|")
            out.append(f"| `{member.findtext('name')}` | `{kind}{' ' + initial if initial else ''}` | {cell(description(member))} |")
        out.append("")
    for member in types:
        if member.get("kind") == "enum":
            out.append(f"`enum {member.findtext('name')}`: " + ", ".join(
                f"`{value.findtext('name')}`{' (' + cell(description(value)) + ')' if description(value) else ''}"
                for value in member.findall("enumvalue")) + f". {description(member)}\n")
        else:
            out.append(f"```cpp\n{signature(member)}\n```\n\n{description(member)}\n")
    for member in sorted(functions, key=line_of):
        ours = member.findtext("name")
        hidden = ours.startswith(("operator=", "~")) or "=delete" in (member.findtext("argsstring") or "").replace(" ", "")
        if hidden or (ours == "operator==" and not description(member)):
            continue
        out.append(f"```cpp\n{signature(member)}\n```\n\n{description(member)}\n")
    return "\n".join(out)


def write_class(compound):
    name = compound.findtext("compoundname").split("::")
    short = "::".join(part for part in name if part[0].isupper() or part in name[-1:])
    return "\n".join([heading(f"{compound.get('kind')} {short}"), description(compound) + "\n", write_members(compound)])


def write_function(member):
    return "\n".join([heading(f"{member.findtext('name')}()"), f"```cpp\n{signature(member)}\n```\n", description(member) + "\n"])


def write_other(member):
    return "\n".join([heading(member.findtext("name")), f"```cpp\n{signature(member)}\n```\n", description(member) + "\n"])


def write_concept(compound):
    return "\n".join([heading(f"concept {compound.findtext('compoundname').split('::')[-1]}"), description(compound) + "\n",
                      f"```cpp\n{plain(compound.find('initializer'))}\n```\n"])


def items_of(compounds):
    """What each header declares: {file: [(line, Markdown, name)]}."""
    found = collections.defaultdict(list)
    for compound in compounds:
        kind = compound.get("kind")
        if kind in ("class", "struct", "union") and compound.get("prot", "public") == "public":
            found[file_of(compound)].append((line_of(compound), write_class(compound), compound.findtext("compoundname")))
        elif kind == "concept":
            found[file_of(compound)].append((line_of(compound), write_concept(compound), compound.findtext("compoundname")))
        elif kind == "namespace" and not compound.findtext("compoundname").startswith(("std", "absl")):
            for member in compound.iter("memberdef"):
                write = {"enum": write_enum, "function": write_function}.get(member.get("kind"), write_other)
                found[file_of(member)].append((line_of(member), write(member), member.findtext("name")))
    return found


def pages(repository, work):
    found = items_of(read_headers(repository, work))
    made, groups = {}, []
    for root, title in ROOTS.items():
        rows, names = [], []
        for header in sorted((repository / root).rglob("*.hpp")):
            included = header.relative_to(repository / root).as_posix()
            items = sorted(found.get(included, ()))
            if not items:
                continue
            page = included.removesuffix(".hpp")
            made[f"{FOLDER}/{page}.md"] = f"# {included}\n\n```cpp\n#include \"{included}\"\n```\n\n" + "\n".join(
                text for _, text, _ in items)
            rows.append(f"| [{included}]({page}.md) | " + ", ".join(
                f"`{name.split('::')[-1]}`" for name in dict.fromkeys(name for _, _, name in items)) + " |")
            names.append(f"{page.removeprefix('segserve/')} <{page}>")
        groups.append(f"## {title}\n\n| header | declares |\n| --- | --- |\n" + "\n".join(rows) +
                      "\n\n```{toctree}\n:hidden:\n\n" + "\n".join(names) + "\n```\n")
    made[f"{FOLDER}/index.md"] = (
        "# The C++ headers\n\nThese are the public headers, made from their comments by Doxygen. They are included as "
        "`#include \"segserve/segment.hpp\"`; [the README](../../README.md#use-it-from-a-program) shows how a program is linked.\n\n"
        + "\n".join(groups))
    return made


if __name__ == "__main__":
    for path, text in pages(pathlib.Path(__file__).resolve().parents[2], pathlib.Path("/tmp/segserve-doxygen")).items():
        print(f"=== {path}\n{text}")
