#!/usr/bin/python3
"""Writes the reference pages of the documentation site from what nodes, commands, launch files, messages and headers
say of themselves.

    make_reference.py BIN ROOT OUT [--xml DOXYGEN]

BIN: folder of the programs; ROOT: of the sources; OUT: of the pages; DOXYGEN: of its XML of the headers, if they are to have
pages, too.
"""

import argparse
import json
import pathlib
import re
import subprocess

import library_pages


def said_by(*words):
    """What a program says; raises where it fails."""
    return subprocess.run([str(word) for word in words], check=True, capture_output=True, text=True, timeout=60).stdout


def value_of(said):
    """A parameter's value as one writes it."""
    if not said:
        return ""
    if not isinstance(said, dict):
        return str(said)
    kind, value = next(iter(said.items()))
    if kind == "boolValue":
        return "true" if value else "false"
    if kind.endswith("List") or isinstance(value, dict):
        return "[" + ", ".join(str(one) for one in next(iter(value.values()), [])) + "]"
    return str(value)


def in_cell(text):
    """Text of a table's cell."""
    return re.sub(r"([|<>*_`\[\]])", r"\\\1", " ".join(text.split()))


def code_cell(text):
    return f"`{text.replace('|', chr(92) + '|')}`" if text else ""


def range_of(parameter):
    choices = [value_of(one) for one in parameter.get("choices", [])]
    if choices:
        return ", ".join(code_cell(one) or '""' for one in choices)
    ends = [value_of(parameter[end]) if end in parameter else "" for end in ("minimum", "maximum")]
    return f"{ends[0]} to {ends[1]}".strip() if any(ends) else ""


def nodes_page(programs):
    page = ["# Nodes", "", "Each is a program of its own, and a name in a launch file. `NAME --help` says the same. A parameter marked *start* "
            "counts when the node starts; the others can be set at any time (`prehend param set NODE NAME VALUE`).", ""]
    for name in said_by(programs / "container", "--list").split():
        described = json.loads(said_by(programs / name, "--describe"))
        page += [f"## {name}", "", in_cell(described["summary"]), ""]
        parameters = described.get("parameters", [])
        if not parameters:
            continue
        page += ["| parameter | default | range | |", "|---|---|---|---|"]
        for one in parameters:
            unit = f" {one['unit']}" if one.get("unit") else ""
            start = "*start*; " if one.get("readOnly") else ""
            page.append(f"| `{one['name']}` | {code_cell(value_of(one.get('defaultValue')))}{unit} | {range_of(one)} "
                        f"| {start}{in_cell(one.get('description', ''))} |")
        page.append("")
    return page


def subcommands(help_text):
    listed = help_text.partition("\nSubcommands:\n")[2].partition("\n\n")[0]
    return re.findall(r"^  ([a-z][\w-]*) ", listed, re.MULTILINE)


def commands_page(program):
    page = ["# Commands", ""]

    def add(words):
        said = said_by(program, *words, "--help")
        page.extend([f"{'#' * min(len(words) + 2, 4)} prehend {' '.join(words)}".rstrip(), "", "```text", said.rstrip(), "```", ""])
        for word in subcommands(said):
            add([*words, word])

    add([])
    return page


def launch_page(program, root):
    page = ["# Launch files", "", "`prehend launch FILE NAME:=VALUE ...`; what they are made of: [launch files](../launch/README.md).", ""]
    for file in sorted((root / "launch").glob("*.yaml")):
        said = said_by(program, "launch", file, "--list-arguments")
        # Files of the tree are named as from its top, wherever it was built; columns stay.
        said = re.sub(re.escape(f"{root.resolve()}/") + r'([^"\n]*")', lambda m: m[1] + " " * (len(m[0]) - len(m[1])), said)
        page += [f"## {file.name}", "", "```text", said.strip(), "```", ""]
    return page


def messages_page(root):
    page = ["# Messages", "", "What topics, services and actions carry (protobuf).", ""]
    for file in sorted((root / "msgs").glob("*.proto")):
        page += [f"## {file.name}", "", "```protobuf", file.read_text().strip(), "```", ""]
    return page


PYTHON = """# Python

What it is for: [Python](../docs/python.md).

```{eval-rst}
.. automodule:: prehend
   :members:
   :imported-members:
   :undoc-members:
   :exclude-members: DescriptionDone
```
"""


def library_page(root, out, xml):
    page = ["# The library", "", "C++20, a folder and a CMake target (`prehend::FOLDER`) a subject; who may depend on whom: "
            "[architecture](../docs/architecture.md).", ""]
    if xml is None:
        return page + ["The headers in `prehend/` say what each function does; `make docs` has them here.", ""]
    names = library_pages.write(root, xml, out / "library")
    return page + ["```{toctree}", ":maxdepth: 2", "", *(f"library/{name}" for name in names), "```", ""]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("bin", type=pathlib.Path)
    parser.add_argument("root", type=pathlib.Path)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--xml", type=pathlib.Path)
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    program = given.bin / "prehend"
    pages = {"nodes": nodes_page(given.bin), "commands": commands_page(program), "launch": launch_page(program, given.root),
             "messages": messages_page(given.root), "python": PYTHON.splitlines(),
             "library": library_page(given.root, given.out, given.xml)}
    for name, lines in pages.items():
        (given.out / f"{name}.md").write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
