"""Pages of the C++ library from Doxygen's XML, a page a folder."""

import pathlib
import xml.etree.ElementTree as ElementTree

SHOWN = ("public-type", "public-func", "public-static-func", "public-static-attrib", "func", "enum", "typedef", "var")


def text_of(element):
    """Plain text of a description, a paragraph a line."""
    if element is None:
        return ""
    paragraphs = []
    for para in element.findall("para"):
        # Parameters and errors come as lists within a paragraph.
        lead = "".join(_flat(para)).strip()
        if lead:
            paragraphs.append(" ".join(lead.split()))
        for item in para.findall("parameterlist/parameteritem"):
            names = ", ".join("".join(name.itertext()) for name in item.iter("parametername"))
            said = " ".join("".join(item.find("parameterdescription").itertext()).split())
            paragraphs.append(f"{names}: {said}")
        for section in para.findall("simplesect"):
            said = " ".join("".join(section.itertext()).split())
            paragraphs.append(f"{'Returns' if section.get('kind') == 'return' else section.get('kind').capitalize()}: {said}")
    seen, once = set(), []
    for one in paragraphs:
        if one not in seen:
            once.append(one)
            seen.add(one)
    return "\n\n".join(once)


def _flat(para):
    yield para.text or ""
    for child in para:
        if child.tag not in ("parameterlist", "simplesect", "para"):
            yield "".join(child.itertext())
        yield child.tail or ""


def escaped(text):
    for mark in "\\`*_<>[]|#$":
        text = text.replace(mark, "\\" + mark)
    return text


def declaration(member):
    if member.get("kind") == "enum":
        values = ", ".join(value.findtext("name") for value in member.findall("enumvalue"))
        return f"enum {member.findtext('name')} {{ {values} }};"
    returned = "".join(member.find("type").itertext()) if member.find("type") is not None else ""
    static = "static " if member.get("static") == "yes" else ""
    return f"{static}{returned} {member.findtext('name')}{member.findtext('argsstring') or ''};".lstrip()


def source_line(root, member):
    """As it is written: what stands behind it says its unit."""
    where = member.find("location")
    lines = (root / where.get("file")).read_text().splitlines()
    return lines[int(where.get("line")) - 1].strip()


def described(element):
    said = [text_of(element.find(part)) for part in ("briefdescription", "detaileddescription", "inbodydescription")]
    return "\n\n".join(escaped(one) for one in said if one)


def members_of(root, compound):
    lines = []
    fields = [member for section in compound.findall("sectiondef") if section.get("kind") == "public-attrib"
              for member in section.findall("memberdef")]
    if fields:
        said = []
        for member in fields:
            said += [f"/// {one}" for one in text_of(member.find("briefdescription")).splitlines() if one]
            said += [f"/// {one}" for one in text_of(member.find("detaileddescription")).splitlines() if one]
            said.append(source_line(root, member))
        lines += ["```cpp", *said, "```", ""]
    for section in compound.findall("sectiondef"):
        if section.get("kind") not in SHOWN:
            continue
        for member in section.findall("memberdef"):
            if member.get("prot") not in (None, "public") or member.get("kind") == "friend":
                continue
            lines += ["```cpp", declaration(member), "```", ""]
            said = described(member)
            if said:
                lines += [said, ""]
    return lines


def compounds(xml):
    """{header: [compounddef of the file, its classes...]}"""
    files, classes = {}, {}
    for file in sorted(xml.glob("*.xml")):
        if file.name in ("index.xml", "Doxyfile.xml"):
            continue
        for compound in ElementTree.parse(file).getroot().iter("compounddef"):
            where = compound.find("location")
            if where is None or compound.get("prot") == "private":
                continue
            if compound.get("kind") == "file":
                files[where.get("file")] = compound
            elif compound.get("kind") in ("class", "struct"):
                classes.setdefault(where.get("file"), []).append(compound)
    return {name: (compound, sorted(classes.get(name, []), key=lambda one: int(one.find("location").get("line"))))
            for name, compound in files.items()}


def write(root, xml, out):
    """Writes out/FOLDER.md; returns their names."""
    by_folder = {}
    for name, parts in compounds(xml).items():
        # Doxygen's names begin where it was told to strip them.
        header = pathlib.Path(name)
        header = header.relative_to(root) if header.is_absolute() else header
        by_folder.setdefault(header.parent, []).append((header, parts))
    out.mkdir(parents=True, exist_ok=True)
    names = []
    for folder, headers in sorted(by_folder.items()):
        lines = [f"# {folder}", ""]
        for header, (file, classes) in sorted(headers):
            body = []
            for one in classes:
                title = one.findtext("compoundname").replace("prehend::", "")
                body += [f"### {escaped(title)}", ""]
                said = described(one)
                body += ([said, ""] if said else []) + members_of(root, one)
            free = members_of(root, file)
            if free:
                body += (["### Free functions and types", ""] if classes else []) + free
            if body:
                lines += [f"## {header.name}", "", "```cpp", f'#include "{header}"', "```", "", *body]
        name = "_".join(folder.parts)
        (out / f"{name}.md").write_text("\n".join(lines) + "\n")
        names.append(name)
    return names
