"""Mission files made by hypothesis: every part of a file, with comments at every place that both notations have."""

from __future__ import annotations

from hypothesis import strategies as st

from target_nav.mission.convert_source import Part, Source, tidy_comment
from target_nav.mission.document import METADATA
from target_nav.mission.problems import Position

HERE = Position("generated")
EXPLICIT = ["SubTree", "Action", "Condition", "Control", "Decorator"]

# What XML can hold at all.
CHARACTERS = st.characters(exclude_categories=["Cs"], exclude_characters="\ufffe\uffff").filter(
    lambda c: c in "\t\n\r" or ord(c) >= 0x20
)
values = st.one_of(
    st.sampled_from(
        [
            "0.10",
            "1e-3",
            "true",
            "no",
            "null",
            "~",
            "",
            " ",
            "{why}",
            "{=}",
            "{@top}",
            "a := 1; b := 'x'",
            "# no",
            "-",
        ]
    ),
    st.sampled_from(
        ["a: b", "a #b", "[x]", "'", '"', "\\", "<&>", "--", "007", "0x1f", "1:20", "2020-01-01", "=", "<<"]
    ),
    st.text(CHARACTERS, max_size=12),
)
names = st.one_of(
    st.sampled_from(
        ["Sequence", "Drive", "y", "on", "speed_mps", "a.b", "_skipIf", "_x", "children", "text", "é", "名"]
    ),
    st.from_regex(r"[A-Za-z_][A-Za-z0-9_.-]{0,8}", fullmatch=True),
)
ports = names.filter(lambda name: name not in ("ID", "name"))
identifiers = values.filter(bool)
tags = names.filter(lambda name: name not in (*EXPLICIT, *METADATA))
words = st.text("abc é#:-'\"{}<&", min_size=1, max_size=10)
comments = st.lists(words, min_size=1, max_size=3).map(tidy_comment).filter(lambda t: t and "--" not in t)
short = comments.filter(lambda text: "\n" not in text)
some_comments = st.one_of(st.just([]), st.lists(comments, max_size=2))
beside = st.one_of(st.just(""), short)


@st.composite
def nodes(draw: st.DrawFn, depth: int = 3) -> Part:
    explicit = draw(st.sampled_from(["", "", "", *EXPLICIT]))
    said = draw(st.dictionaries(ports, values, max_size=3))
    children = draw(st.lists(nodes(depth - 1), max_size=3)) if depth and draw(st.booleans()) else []
    if children:
        # the one name that means something else in YAML then
        said.pop("children", None)
    attributes = list(said.items())
    if draw(st.booleans()):
        attributes.append(("name", draw(values)))
    if explicit:
        attributes.insert(0, ("ID", draw(identifiers)))
    part = Part(explicit or draw(tags), attributes, "", HERE, children)
    return with_comments(draw, part)


def with_comments(draw: st.DrawFn, part: Part, end: bool = True) -> Part:
    part.before = draw(some_comments)
    part.beside = draw(beside)
    part.end = draw(some_comments) if part.children and end else []
    return part


@st.composite
def includes(draw: st.DrawFn) -> Part:
    attributes = [("path", draw(values.filter(str.strip)))]
    if draw(st.booleans()):
        attributes.append(("ros_pkg", draw(values)))
    return with_comments(draw, Part("include", attributes, "", HERE))


@st.composite
def model_entries(draw: st.DrawFn) -> Part:
    directions = st.sampled_from(["input_port", "output_port", "inout_port"])
    children = []
    for _ in range(draw(st.integers(0, 2))):
        said = [
            ("name", draw(identifiers)),
            *draw(st.dictionaries(st.sampled_from(["default", "type"]), values)).items(),
        ]
        text = draw(values).strip()
        children.append(with_comments(draw, Part(draw(directions), said, text, HERE)))
    return with_comments(
        draw, Part(draw(st.sampled_from(EXPLICIT)), [("ID", draw(identifiers))], "", HERE, children)
    )


@st.composite
def sources(draw: st.DrawFn) -> Source:
    """Any mission file whose frame is right, its sections in the order in which they are written."""
    root = Part("root", [("BTCPP_format", "4")], "", HERE)
    for name in draw(st.sets(st.sampled_from(["main_tree_to_execute", "project_name", "xmlns:xsi"]))):
        root.attributes.append((name, draw(values)))
    root.children.extend(draw(st.lists(includes(), max_size=2)))
    for identifier in draw(st.lists(identifiers, min_size=1, max_size=3, unique=True)):
        private = draw(st.dictionaries(st.sampled_from(METADATA), values, max_size=1))
        node = draw(nodes())
        tree = Part("BehaviorTree", [("ID", identifier), *private.items()], "", HERE, [node])
        # behind a tree's only node is the end of that node's children
        root.children.append(with_comments(draw, tree, end=not node.children))
    if draw(st.booleans()):
        entries = draw(st.lists(model_entries(), max_size=2))
        root.children.append(with_comments(draw, Part("TreeNodesModel", [], "", HERE, entries)))
    root.before = draw(some_comments)
    return Source(root, draw(some_comments))
