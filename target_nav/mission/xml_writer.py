"""A mission as XML for BehaviorTree.CPP and Groot2, in one form: two spaces a level, long tags on several lines."""

from __future__ import annotations

import re

from target_nav.mission.convert_source import Part, Source

WIDTH = 110
_ESCAPES = {"&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;", "\t": "&#9;", "\n": "&#10;", "\r": "&#13;"}
_ESCAPED = re.compile('[&<>"\t\n\r]')


def write_xml(source: Source) -> str:
    """The file's text."""
    writer = _Writer()
    writer.lines.append('<?xml version="1.0" encoding="UTF-8"?>')
    writer.part(source.root, "")
    for text in source.footer:
        writer.comment(text, "")
    return "\n".join(writer.lines) + "\n"


class _Writer:
    def __init__(self) -> None:
        self.lines: list[str] = []

    def part(self, part: Part, indent: str) -> None:
        for text in part.before:
            self.comment(text, indent)
        closed = not part.children and not part.end and not part.text
        opening = _tag(part, indent, "/>" if closed else ">")
        beside = f"  <!-- {_comment_text(part.beside)} -->" if part.beside else ""
        if part.text and not part.children and not part.end:
            self.lines.append(f"{opening}{_content(part.text)}</{part.tag}>{beside}")
            return
        self.lines.append(opening + beside)
        if closed:
            return
        if part.text:
            self.lines.append(f"{indent}  {_content(part.text)}")
        for child in part.children:
            if part.tag == "root" and child.tag != "include":
                self.lines.append("")
            self.part(child, indent + "  ")
        for text in part.end:
            self.comment(text, indent + "  ")
        self.lines.append(f"{indent}</{part.tag}>")

    def comment(self, text: str, indent: str) -> None:
        first, *others = _comment_text(text).split("\n")
        lines = [f"{indent}<!-- {first}", *(f"{indent}     {line}".rstrip() for line in others)]
        lines[-1] += " -->"
        self.lines.extend(lines)


def _tag(part: Part, indent: str, end: str) -> str:
    said = [f'{name}="{_escaped(value)}"' for name, value in part.attributes]
    one_line = f"{indent}<{' '.join([part.tag, *said])}{end}"
    if len(one_line) <= WIDTH or len(said) < 2:
        return one_line
    gap = "\n" + indent + " " * (len(part.tag) + 2)
    return f"{indent}<{part.tag} {gap.join(said)}{end}"


def _escaped(text: str) -> str:
    return _ESCAPED.sub(lambda match: _ESCAPES[match.group()], text)


def _content(text: str) -> str:
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;").replace("\r", "&#13;")


def _comment_text(text: str) -> str:
    """XML has no `--` in a comment."""
    return re.sub("-(?=-)", "- ", text)
