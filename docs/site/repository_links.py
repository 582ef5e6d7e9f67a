#!/usr/bin/python3
"""Makes links of copied pages that lead to files or folders of the repository that are no pages plain text: the site has
them not. Links to what is not there stay, for Sphinx to complain of.

    repository_links.py ROOT COPIES
"""

import pathlib
import re
import sys

LINK = re.compile(r"(?<!!)\[([^\]]*)\]\(([^)#\s]+)(#[^)\s]*)?\)")


def main(root, copies):
    for page in copies.rglob("*.md"):
        folder = root / page.relative_to(copies).parent

        def plain(match):
            target = match.group(2)
            if "://" in target or target.startswith("mailto:"):
                return match.group(0)
            is_page = (page.parent / target).resolve().is_file()
            return match.group(1) if not is_page and (folder / target).exists() else match.group(0)

        text = page.read_text()
        changed = LINK.sub(plain, text)
        if changed != text:
            page.write_text(changed)


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]))
