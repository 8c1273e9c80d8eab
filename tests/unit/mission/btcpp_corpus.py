"""The missions in BehaviorTree.CPP's own tests and examples: how many of them target_nav loads, and why not the others.

They come with the source distribution of `behaviortreepy` on PyPI, which is downloaded and never committed. By hand:

    python -m tests.unit.mission.btcpp_corpus [FOLDER]

FOLDER is where that is kept, or the unpacked sources. The leaves are C++ classes; stand-ins take their places, with the
ports that the sources give them.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tarfile
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

from py_trees.blackboard import Blackboard
from py_trees.ports import PortInformation

from target_nav.mission import NodeRegistry
from target_nav.mission.check import analyse
from target_nav.mission.model import Form
from tests.unit.mission.scripted import leaf_class

PACKAGE = "behaviortreepy==0.1.4"
PLACES = ("tests", "examples", "fuzzing", "sample_nodes")

_RAW_STRING = re.compile(r'R"(?P<mark>\w*)\((?P<text>.*?)\)(?P=mark)"', re.DOTALL)
_PORT = re.compile(r'(Input|Output|Bidirectional)Port(?:<[^()]*?>)?\(\s*"(\w+)"')
_SET = re.compile(r'set(?:<[\w:]+>)?\(\s*"(@?\w+)"')
_ENUM = re.compile(r'registerScriptingEnum\(\s*"(\w+)"\s*,\s*(\d+)')
_ENUM_CLASS = re.compile(r"\benum\s+(?:class\s+)?\w*[^{;()]*\{([^}]*)\}")
_MAIN_TREE = re.compile(r'createTree\(\s*"(\w+)"')
_BROKEN_LITERAL = re.compile(r'"\s*\n\s*"')
_TREE_ID = re.compile(r'<BehaviorTree\s[^>]*?ID\s*=\s*"([^"]+)"')
_SUBTREE_ID = re.compile(r'<SubTree\s[^>]*?ID\s*=\s*"([^"]+)"')


@dataclass(frozen=True)
class Source:
    """One mission. `name` is the file and which of its texts it is; `code` what stands beside it."""

    name: str
    text: str
    code: str
    path: Path | None = None


@dataclass(frozen=True)
class Outcome:
    source: Source
    problems: tuple[str, ...]


def download(folder: Path) -> Path | None:
    """The unpacked sources in `folder`, fetched if they are not there; None when they cannot be had."""
    found = [each.parent for each in folder.glob("**/BehaviorTree.CPP/package.xml")]
    if found:
        return found[0]
    folder.mkdir(parents=True, exist_ok=True)
    command = [
        sys.executable,
        "-m",
        "pip",
        "download",
        "--quiet",
        "--no-deps",
        "--no-binary",
        "behaviortreepy",
    ]
    try:
        subprocess.run(
            [*command, "--dest", str(folder), PACKAGE], check=True, timeout=100, capture_output=True
        )
        (archive,) = folder.glob("behaviortreepy-*.tar.gz")
        with tarfile.open(archive) as content:
            content.extractall(folder, filter="data")
    except (OSError, ValueError, subprocess.SubprocessError, tarfile.TarError):
        return None
    return next((each.parent for each in folder.glob("**/BehaviorTree.CPP/package.xml")), None)


def missions(sources: Path) -> Iterator[Source]:
    """Every text that looks like one, in the order of the files."""
    files = [path for place in PLACES for path in sorted((sources / place).glob("**/*")) if path.is_file()]
    for path in files:
        name = str(path.relative_to(sources))
        if path.suffix == ".xml":
            yield Source(name, path.read_text(encoding="utf-8", errors="replace"), "", path)
        elif path.suffix in (".cpp", ".h", ".hpp"):
            code = path.read_text(encoding="utf-8", errors="replace")
            for number, text in enumerate(_texts(code), 1):
                yield Source(f"{name}#{number}", text, code)


def ports_in(code: str) -> dict[str, str]:
    """Ports by name: Input, Output or Bidirectional."""
    return {name: direction for direction, name in _PORT.findall(_BROKEN_LITERAL.sub("", code))}


def enums_in(code: str) -> dict[str, int]:
    found = {name: int(value) for name, value in _ENUM.findall(code)}
    for body in _ENUM_CLASS.findall(code):
        value = -1
        for member in re.sub(r"//[^\n]*", "", body).split(","):
            name, _, said = member.partition("=")
            value = int(said) if said.strip().isdigit() else value + 1
            if name.strip().isidentifier():
                found.setdefault(name.strip(), value)
    return found


def main_tree_of(source: Source) -> str | None:
    """The tree that the C++ code beside a mission makes of it; the last one it has, if that does not say."""
    trees = _TREE_ID.findall(source.text)
    if not trees or "main_tree_to_execute" in source.text:
        return None
    wanted = [name for name in _MAIN_TREE.findall(source.code) if name in trees]
    return wanted[0] if wanted else trees[-1]


def with_includes(source: Source, folder: Path) -> str:
    """The text, including those beside it that have the trees it lacks: the C++ code registers several."""
    lacking = set(_SUBTREE_ID.findall(source.text)) - set(_TREE_ID.findall(source.text))
    includes = ""
    for number, text in enumerate(_texts(source.code)):
        trees = set(_TREE_ID.findall(text))
        if lacking & trees and not trees & set(_TREE_ID.findall(source.text)):
            (folder / f"beside_{number}.xml").write_text(text, encoding="utf-8")
            includes += f'<include path="beside_{number}.xml"/>'
            lacking -= trees
    return re.sub(r"(<root[^>]*>)", rf"\1{includes}", source.text, count=1)


def _texts(code: str) -> list[str]:
    texts = [match["text"].strip() for match in _RAW_STRING.finditer(code)]
    return [each for each in texts if each.startswith(("<root", "<?xml")) and each.endswith("</root>")]


def registry_for(source: Source, ports: dict[str, str]) -> NodeRegistry:
    registry = NodeRegistry(enums=enums_in(source.code))
    elements: list[ElementTree.Element] = []
    for text in (source.text, *_texts(source.code)):
        try:
            elements += [
                each for tree in ElementTree.fromstring(text).iter("BehaviorTree") for each in tree.iter()
            ]
        except ElementTree.ParseError:
            continue
    trees = {each.get("ID") for each in elements if each.tag == "BehaviorTree"}
    uses: dict[str, dict[str, str]] = {}
    for element in elements:
        explicit = element.tag in [form.value for form in Form if form.value]
        name = element.get("ID", "") if explicit else element.tag
        known = registry.find(name) is not None or element.tag in ("BehaviorTree", Form.SUBTREE.value)
        if not known and name not in trees and not len(element):
            uses.setdefault(name, {}).update(element.attrib)
    for name, attributes in uses.items():
        inputs, outputs = {}, {}
        for port, value in attributes.items():
            direction = ports.get(port)
            if direction is None or not port.isidentifier() or port.startswith("_") or port in ("name", "ID"):
                continue
            is_output = direction == "Output" or (
                direction == "Bidirectional" and value.strip()[:1] in ("{", "=")
            )
            (outputs if is_output else inputs)[port] = PortInformation(object, False, "")
        if name.isidentifier():
            registry.register(leaf_class(name, inputs, outputs))
    return registry


def outcomes(sources: Path) -> list[Outcome]:
    nodes = sorted((sources / "sample_nodes").glob("*.*"))
    shared = "\n".join(path.read_text(encoding="utf-8", errors="replace") for path in nodes)
    found = []
    with tempfile.TemporaryDirectory() as folder:
        for source in missions(sources):
            path = source.path
            if path is None:
                path = Path(folder) / "mission.xml"
                path.write_text(with_includes(source, Path(folder)), encoding="utf-8")
            ports = ports_in(shared) | ports_in(source.code)
            provided = [f"/{key.lstrip('@')}" for key in _SET.findall(source.code)]
            Blackboard.clear()
            analysis = analyse(path, registry_for(source, ports), provided, main_tree_of(source))
            shown = tuple(str(each).replace(f"{path}:", "") for each in analysis.errors)
            found.append(Outcome(source, shown))
    return found


def main() -> None:
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(".cache/btcpp")
    sources = download(folder)
    if sources is None:
        sys.exit(f"{PACKAGE} could not be downloaded to {folder}; is there a network?")
    every = outcomes(sources)
    for outcome in every:
        if outcome.problems:
            print(outcome.source.name, *(f"    {each}" for each in outcome.problems), sep="\n")
    refused = sum(bool(outcome.problems) for outcome in every)
    print(f"{len(every)} missions: {len(every) - refused} loaded, {refused} refused")


if __name__ == "__main__":
    main()
