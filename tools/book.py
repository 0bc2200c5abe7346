#!/usr/bin/env python3
"""A preprocessor of mdBook (book.toml): the pages are written for the repository, in which they also lead to files outside of docs.

The overview is README.md of the repository; in the book it lies beside the other pages. What lies outside of the book is named there, not linked.
"""
import base64
import json
import pathlib
import posixpath
import re
import sys

OVERVIEW = "overview.md"
LINK = re.compile(r"(!?)\[((?:[^][]|\[[^][]*\])*)\]\(([^)\s]+)\)")
CODE = re.compile(r"(```.*?```|`[^`\n]*`)", re.DOTALL)


def links(text, folder, root, source):
    """The text of a page in this folder of the repository, with its links as they are in the book."""

    def link(match):
        image, words, target = match.groups()
        path, _, anchor = target.partition("#")
        if not path or "://" in path or path.startswith("mailto:"):
            return match[0]
        place = posixpath.normpath(posixpath.join(folder, path))
        if image and not place.startswith(source + "/"):
            picture = base64.b64encode((root / place).read_bytes()).decode()
            return f"![{words}](data:image/svg+xml;base64,{picture})"
        if place == "README.md":
            place = posixpath.join(source, OVERVIEW)
        if not place.startswith(source + "/"):
            return words if place in words else f"{words} (`{place}`)"
        # The overview moves from the repository's folder into that of the pages.
        home = source if folder == "" else folder
        return f"{image}[{words}]({posixpath.relpath(place, home)}{'#' + anchor if anchor else ''})"

    parts = CODE.split(text)
    # Links around code, as in [`name`](page), span several parts: code within them is put back afterwards.
    codes = []

    def hide(part):
        codes.append(part)
        return f"\0{len(codes) - 1}\0"

    hidden = "".join(hide(part) if CODE.fullmatch(part) else part for part in parts)
    return re.sub("\0(\\d+)\0", lambda match: codes[int(match[1])], LINK.sub(link, hidden))


def chapters(items, root, source):
    for item in items:
        chapter = item.get("Chapter") if isinstance(item, dict) else None
        if chapter is None:
            continue
        if chapter["path"]:
            place = posixpath.normpath(posixpath.join(source, chapter["path"].replace("\\", "/")))
            chapter["content"] = links(chapter["content"], posixpath.dirname(place), root, source)
            if place == "README.md":
                chapter["path"] = OVERVIEW
        chapters(chapter["sub_items"], root, source)


def main():
    if sys.argv[1:2] == ["supports"]:
        return
    context, book = json.load(sys.stdin)
    items = book["sections"] if "sections" in book else book["items"]
    chapters(items, pathlib.Path(context["root"]), context["config"]["book"]["src"])
    json.dump(book, sys.stdout)


main()
