"""A mission as YAML, in one form: a node's ports on its line where they fit, each on its own where they do not."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable

from target_nav.errors import MissionError
from target_nav.mission.convert_source import Part, Source
from target_nav.mission.yaml_reader import INCLUDE, MODELS, TREES
from target_nav.mission.yaml_reader_elements import CHILDREN, TEXT

WIDTH = 100

_NUMBER = re.compile(r"[-+]?(0|[1-9][0-9]*)(\.[0-9]+)?")
_WORDS = re.compile(r"[A-Za-z_][A-Za-z0-9_./-]*( [A-Za-z0-9_./()-]+)*")
_LINE_OF_WORDS = re.compile(r"[A-Za-z_][A-Za-z0-9_./-]*,?( [A-Za-z0-9_./()-]+,?)*")
"""On a line of its own a text may have commas as well."""
_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_.-]*")
# Words that other readers of YAML take for something else than text.
_TAKEN = {"y", "n", "yes", "no", "on", "off", "null", "true", "false"}
_UNSEEN = re.compile("[^\\x20-\\x7e\\xa0-\\ud7ff\\ue000-\\ufefe\\uff00-\\ufffd\\U00010000-\\U0010ffff\\n]")


def write_yaml(source: Source) -> str:
    """The file's text.

    Raises:
        MissionError: it has what YAML has no place for.
    """
    writer = _Writer()
    writer.mission(source)
    return "\n".join(writer.lines) + "\n"


class _Writer:
    def __init__(self) -> None:
        self.lines: list[str] = []

    def mission(self, source: Source) -> None:
        root = source.root
        self._comments(root.before, 0)
        for name, value in root.attributes:
            self.lines.append(f"{_key(name)}: {_scalar(value)}")
        self._includes([child for child in root.children if child.tag == "include"])
        self._trees([child for child in root.children if child.tag == "BehaviorTree"])
        for models in (child for child in root.children if child.tag == MODELS):
            self._models(models)
        if source.footer:
            self.lines.append("")
            self._comments(source.footer, 0)

    # -- sections ----------------------------------------------------------------------------------------------------

    def _includes(self, includes: list[Part]) -> None:
        if includes:
            self.lines.append(f"{INCLUDE}:")
        for include in includes:
            self._comments(include.before, 2)
            if [name for name, _ in include.attributes] == ["path"]:
                text = _scalar(include.attributes[0][1])
            else:
                text = f"{{{_pairs(include.attributes)}}}"
            self.lines.append(f"  - {text}{_beside(include)}")

    def _trees(self, trees: list[Part]) -> None:
        if trees:
            self.lines.extend(["", f"{TREES}:"])
        seen: set[str] = set()
        for number, tree in enumerate(trees):
            identifier = tree.get("ID") or ""
            if identifier in seen:
                raise MissionError(f'{tree.position}: error: a second tree "{identifier}" in one file')
            seen.add(identifier)
            if number:
                self.lines.append("")
            self._comments(tree.before, 2)
            (node,) = tree.children
            private = [(name, value) for name, value in tree.attributes if name != "ID"]
            if (
                not private
                and not node.attributes
                and not node.children
                and not node.before
                and not node.beside
            ):
                self.lines.append(f"  {_scalar(identifier)}: {_scalar(node.tag)}{_beside(tree)}")
            else:
                self.lines.append(f"  {_scalar(identifier)}:{_beside(tree)}")
                self.lines.extend(f"    {_key(name)}: {_scalar(value)}" for name, value in private)
                self._comments(node.before, 4)
                self._node(node, "    ", 4, is_item=False)
            self._comments(tree.end, 4)

    def _models(self, models: Part) -> None:
        self.lines.append("")
        self._comments(models.before, 0)
        self.lines.append(f"{MODELS}:{'' if models.children else ' []'}{_beside(models)}")
        self._children(models, 2, in_model=True)

    # -- nodes -------------------------------------------------------------------------------------------------------

    def _children(self, part: Part, column: int, in_model: bool = False) -> None:
        for child in part.children:
            self._comments(child.before, column)
            self._node(child, " " * column + "- ", column, is_item=True, in_model=in_model)
        self._comments(part.end, column)

    def _node(self, part: Part, lead: str, column: int, is_item: bool, in_model: bool = False) -> None:
        """`column` is that of the dash, or of the name where there is none."""
        pairs = self._pairs_of(part, in_model)
        name, beside = _key(part.tag), _beside(part)
        inner = column + 2 if is_item else column
        if not pairs and not part.children:
            # a name alone is a text in a list, but needs a colon where it is a key
            self.lines.append(f"{lead}{name}{'' if is_item else ':'}{beside}")
            return
        if not pairs:
            self.lines.append(f"{lead}{name}:{beside}")
            self._children(part, inner, in_model)
            return
        one_line = f"{lead}{name}: {{{_pairs(pairs)}}}"
        if not part.children and len(one_line) <= WIDTH:
            self.lines.append(one_line + beside)
            return
        self.lines.append(f"{lead}{name}:{beside}")
        self.lines.extend(f"{' ' * (inner + 2)}{_key(port)}: {_scalar(value)}" for port, value in pairs)
        if part.children:
            self.lines.append(f"{' ' * (inner + 2)}{CHILDREN}:")
            self._children(part, inner + 2, in_model)

    @staticmethod
    def _pairs_of(part: Part, in_model: bool) -> list[tuple[str, str]]:
        pairs = list(part.attributes)
        for name, value in pairs:
            if (name == CHILDREN and part.children) or (in_model and name == TEXT):
                raise MissionError(
                    f'{part.position}: error: <{part.tag}> has an attribute {name}="{value}", which YAML cannot tell '
                    f"from its {name}; call it something else"
                )
        if part.text:
            pairs.append((TEXT, part.text))
        return pairs

    def _comments(self, comments: Iterable[str], column: int) -> None:
        for number, text in enumerate(comments):
            if number:
                # without it the two would be one comment
                self.lines.append("")
            for line in _seen(text).split("\n"):
                self.lines.append(f"{' ' * column}# {line}".rstrip())


def _beside(part: Part) -> str:
    return f"  # {_seen(part.beside)}" if part.beside else ""


def _pairs(pairs: Iterable[tuple[str, str]]) -> str:
    return ", ".join(f"{_key(name)}: {_scalar(value, in_braces=True)}" for name, value in pairs)


def _key(name: str) -> str:
    return (
        name
        if _NAME.fullmatch(name) and name.casefold() not in _TAKEN
        else json.dumps(name, ensure_ascii=False)
    )


def _scalar(text: str, in_braces: bool = False) -> str:
    """Without quotes where every reader of YAML takes it for what it is."""
    if _NUMBER.fullmatch(text) or text in ("true", "false"):
        return text
    if (_WORDS if in_braces else _LINE_OF_WORDS).fullmatch(text) and text.casefold() not in _TAKEN:
        return text
    # JSON's quoted text is YAML's too, but for characters that only YAML wants escaped
    return _UNSEEN.sub(_escape, json.dumps(text, ensure_ascii=False))


def _escape(match: re.Match[str]) -> str:
    code = ord(match.group())
    return f"\\u{code:04x}" if code <= 0xFFFF else f"\\U{code:08x}"


def _seen(text: str) -> str:
    """A comment without the characters that YAML does not allow in one."""
    return _UNSEEN.sub("\N{REPLACEMENT CHARACTER}", text)
