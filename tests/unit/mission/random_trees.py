"""Random missions for the comparison with BehaviorTree.CPP: every node it has, conditions, scripts, subtrees.

Two kinds of leaves: stateful ones (`A0`: begun, ticked, halted) and immediate ones (`C0`: SUCCESS or FAILURE in one
tick). `W0` is immediate too, and writes the blackboard. What entries there are is told by `random_scripts`.
"""

from __future__ import annotations

import random
import re
from dataclasses import dataclass, field
from xml.sax.saxutils import quoteattr

from tests.unit.mission.random_scripts import MAIN, PRELUDE, Expressions, Scope
from tests.unit.mission.scripted import document

TICKS = 12

CONTROLS = (
    "Sequence", "Fallback", "SequenceWithMemory", "ReactiveSequence", "ReactiveFallback", "AsyncSequence",
    "AsyncFallback", "Parallel", "ParallelAll",
)  # fmt: skip
CALM_CONTROLS = ("Sequence", "Fallback", "SequenceWithMemory", "AsyncSequence", "AsyncFallback")
"""Those that halt no child that runs."""
DECORATORS = (
    "Inverter", "ForceSuccess", "ForceFailure", "KeepRunningUntilFailure", "Repeat", "RetryUntilSuccessful",
    "RunOnce", "Timeout", "Precondition", "LoopInt", "LoopDouble", "LoopString", "LoopBool", "SkipUnlessUpdated",
    "WaitValueUpdate",
)  # fmt: skip


@dataclass
class Trial:
    """One generated mission. `scripts` are what leaves return, `writes` what the writing ones write (entry, value).

    `halts` are the ticks after which the tree is halted, from outside.
    """

    xml: str
    scripts: dict[str, str]
    writes: dict[str, tuple[str, float]]
    halts: frozenset[int]


@dataclass
class Maker:
    rng: random.Random
    mixes: bool = True
    scripts: dict[str, str] = field(default_factory=dict)
    writes: dict[str, tuple[str, float]] = field(default_factory=dict)
    trees: list[str] = field(default_factory=list)
    halts_noticed: bool = False
    """Whether something of `_onHalted` is in it."""

    def __post_init__(self) -> None:
        self.say = Expressions(self.rng, self.mixes)

    # -- what a tag says besides -------------------------------------------------------------------------------------

    def conditions(self, scope: Scope, before: bool = True, calm: bool = False) -> str:
        if self.rng.random() > 0.3:
            return ""
        found = {}
        for _ in range(self.rng.choice((1, 1, 2))):
            roll = self.rng.random()
            if before and roll < 0.55:
                names = ("_failureIf", "_successIf", "_skipIf", *(() if calm else ("_while",)))
                found[self.rng.choice(names)] = self.say.condition(scope)
            elif roll < 0.9 or calm:
                found[self.rng.choice(("_onSuccess", "_onFailure", "_post"))] = self.say.script(scope)
            else:
                found["_onHalted"] = self.on_halted()
        return "".join(f" {name}={quoteattr(text)}" for name, text in found.items())

    def on_halted(self) -> str:
        """One that cannot fail: there, the end of the tree is a halt too, and a failure the end of the process."""
        self.halts_noticed = True
        return self.rng.choice(("@i0 += 1", "@d1 := 0.25", "@t0 := 'h'", "@i1 := 7; @i0 -= 1"))

    # -- leaves ------------------------------------------------------------------------------------------------------

    def leaf(self, scope: Scope, calm: bool) -> str:
        if self.rng.random() < 0.5:
            return self.immediate(scope)
        name = f"A{len(self.scripts)}"
        self.scripts[name] = "".join(self.rng.choices("SFR", (3, 2, 4), k=self.rng.randint(1, 6)))
        return f"<{name}{self.conditions(scope, calm=calm)}/>"

    def immediate(self, scope: Scope) -> str:
        roll = self.rng.random()
        conditions = self.conditions(scope)
        if roll < 0.2:
            return self.rng.choice(
                (f"<AlwaysSuccess{conditions}/>", f"<AlwaysFailure{conditions}/>", '<Sleep msec="0"/>')
            )
        if roll < 0.4:
            return f"<Script code={quoteattr(self.say.script(scope))}{conditions}/>"
        if roll < 0.55:
            return f"<ScriptCondition code={quoteattr(self.say.condition(scope))}{conditions}/>"
        if roll < 0.65:
            return (
                f'<WasEntryUpdated entry="{self.rng.choice(("{u0}", "u0", "{@u0}", "{d0}"))}"{conditions}/>'
            )
        if roll < 0.72:
            return f'<SetBlackboard output_key="s0" value="{self.rng.choice(("a", "5", "", "true"))}"{conditions}/>'
        if roll < 0.77:
            kind = self.rng.choice("di")
            return f'<SetBlackboard output_key="c_{kind}" value="{{@{kind}0}}"{conditions}/>'
        if roll < 0.82 and scope.own:
            return f'<UnsetBlackboard key="x0"{conditions}/>'
        if roll < 0.9:
            name = f"W{len(self.scripts)}"
            key = self.rng.choice(("u0", "i0", "i1"))
            self.writes[name] = (
                key,
                float(self.rng.randint(0, 2)) if key == "u0" else self.rng.randint(0, 4),
            )
        else:
            name = f"C{len(self.scripts)}"
        self.scripts[name] = "".join(self.rng.choices("SF", k=self.rng.randint(1, 5)))
        return f"<{name}{conditions}/>"

    def decision(self, scope: Scope) -> str:
        """For IfThenElse and WhileDoElse: immediate, never skipped; see docs/mission-language.md."""
        name = f"C{len(self.scripts)}"
        self.scripts[name] = "".join(self.rng.choices("SF", k=self.rng.randint(1, 5)))
        after = self.conditions(scope, before=False)
        script = f"<ScriptCondition code={quoteattr(self.say.condition(scope))}{after}/>"
        return self.rng.choice((f"<{name}{after}/>", f"<Inverter><{name}/></Inverter>", script))

    # -- trees -------------------------------------------------------------------------------------------------------

    def node(self, depth: int, scope: Scope, calm: bool = False) -> str:
        roll = self.rng.random()
        if depth <= 0 or roll < 0.15:
            return self.leaf(scope, calm)
        if roll < 0.2 and not calm:
            return self.skipper(scope)
        if roll < 0.5:
            return self.control(depth, scope, calm)
        if roll < 0.58 and not calm:
            return self.branching(depth, scope)
        if roll < 0.66:
            return self.switch(depth, scope) if not calm else self.control(depth, scope, calm)
        if roll < 0.74 and len(self.trees) < 3:
            return self.subtree(depth, scope, calm)
        return self.decorator(depth, scope, calm)

    def skipper(self, scope: Scope) -> str:
        """A node that is skipped with its child, and so may stay active: what is asked of it then, what halts it?"""
        tag = self.rng.choice(
            ("Sequence", "Fallback", "ReactiveSequence", "ReactiveFallback", "SequenceWithMemory", "Parallel",
             "ParallelAll", "Inverter", "ForceFailure", "Repeat", "RetryUntilSuccessful", "Precondition", "Switch2")
        )  # fmt: skip
        children = "".join(self.skipped() for _ in range(3 if tag == "Switch2" else 1))
        own = f" _onHalted={quoteattr(self.on_halted())}"
        if self.rng.random() < 0.5:
            name = self.rng.choice(("_failureIf", "_successIf", "_skipIf"))
            own += f" {name}={quoteattr(self.say.in_time())}"
        ports = {
            "Repeat": ' num_cycles="2"',
            "RetryUntilSuccessful": ' num_attempts="2"',
            "Precondition": f' if={quoteattr(self.say.in_time())} else="SKIPPED"',
            "Switch2": ' variable="{@v0}" case_1="1" case_2="2"',
        }.get(tag, "")
        return f"<{tag}{ports}{own}>{children}</{tag}>"

    def skipped(self) -> str:
        name = f"{self.rng.choice('AC')}{len(self.scripts)}"
        self.scripts[name] = "".join(
            self.rng.choices("SFR" if name[0] == "A" else "SF", k=self.rng.randint(1, 4))
        )
        return f"<{name} _skipIf={quoteattr(self.say.in_time())}/>"

    def children(self, depth: int, scope: Scope, calm: bool, least: int = 1, most: int = 4) -> str:
        return "".join(self.node(depth - 1, scope, calm) for _ in range(self.rng.randint(least, most)))

    def control(self, depth: int, scope: Scope, calm: bool = False) -> str:
        tag = self.rng.choice(CALM_CONTROLS if calm else CONTROLS)
        count, attributes = self.rng.randint(1, 4), ""
        if tag == "Parallel":
            for port in ("success_count", "failure_count"):
                if self.rng.random() < 0.7:
                    attributes += f' {port}="{self.rng.randint(-count, count)}"'
        elif tag == "ParallelAll" and self.rng.random() < 0.7:
            attributes = f' max_failures="{self.rng.randint(-count, count)}"'
        children = self.children(depth, scope, calm, count, count)
        return f"<{tag}{attributes}{self.conditions(scope, calm=calm)}>{children}</{tag}>"

    def branching(self, depth: int, scope: Scope) -> str:
        tag = self.rng.choice(("IfThenElse", "WhileDoElse"))
        branches = self.children(depth, scope, False, 1, 2)
        return f"<{tag}{self.conditions(scope)}>{self.decision(scope)}{branches}</{tag}>"

    def switch(self, depth: int, scope: Scope) -> str:
        count = self.rng.choice((2, 2, 3, 4, 5, 6))
        if self.rng.random() < 0.6:
            variable, cases = (
                "{@v0}",
                [self.rng.choice(("0", "1", "2", "3", "1.0", "{@v1}")) for _ in range(count)],
            )
        else:
            variable, cases = "{@t0}", [self.rng.choice(("a", "b", "e", "{@t1}")) for _ in range(count)]
        said = "".join(f' case_{number}="{case}"' for number, case in enumerate(cases, 1))
        children = self.children(min(depth, 2), scope, False, count + 1, count + 1)
        return (
            f'<Switch{count} variable="{variable}"{said}{self.conditions(scope)}>{children}</Switch{count}>'
        )

    def decorator(self, depth: int, scope: Scope, calm: bool) -> str:
        tag = self.rng.choice(DECORATORS)
        if_empty = self.rng.choice(
            ("", *(f' if_empty="{status}"' for status in ("SUCCESS", "FAILURE", "SKIPPED")))
        )
        attributes = {
            "Repeat": f' num_cycles="{self.rng.choice(("-1", "0", "1", "2", "{@p0}", "{@p0}"))}"',
            "RetryUntilSuccessful": f' num_attempts="{self.rng.choice(("-1", "0", "1", "3", "{@p0}", "{@p0}"))}"',
            "RunOnce": self.rng.choice(("", ' then_skip="false"', ' then_skip="true"', ' then_skip="{@b0}"')),
            "Timeout": f' msec="{self.rng.choice((0, 1_000_000))}"',
            "Precondition": f" if={quoteattr(self.say.condition(scope))}"
            + self.rng.choice(
                ("", *(f' else="{status}"' for status in ("SUCCESS", "FAILURE", "SKIPPED", "RUNNING")))
            ),
            "LoopInt": f' queue="{self.rng.choice(("1;2;3", "7", "-1;1;"))}" value="{{j0}}"{if_empty}',
            "LoopDouble": f' queue="{self.rng.choice(("1.5;2", "0", "-1;1e1"))}" value="{{q0}}"{if_empty}',
            "LoopString": f' queue="{self.rng.choice(("a;b;", "x", ""))}" value="{{r0}}"{if_empty}',
            "LoopBool": f' queue="true;false"{if_empty}',
            "SkipUnlessUpdated": f' entry="{self.rng.choice(("{u0}", "u0", "@u0", "{d0}"))}"',
            "WaitValueUpdate": f' entry="{self.rng.choice(("{u0}", "u0", "@u0", "{i0}"))}"',
        }.get(tag, "")
        if tag in ("SkipUnlessUpdated", "WaitValueUpdate") and not calm:
            # There, halting them does not halt their child, so it had better not run; see docs/mission-language.md.
            child = self.immediate(scope)
        else:
            child = self.node(depth - 1, scope, calm)
        if "@p0" in attributes and self.rng.random() < 0.7:
            # The count changes while it is counted. Not while the child runs: there, it would then run on.
            attributes = attributes.replace("@p0", "@p1")
            script = f'<Script code="@p1 := {self.rng.randint(0, 3)}"/>'
            child = f"<Sequence>{script}{self.immediate(scope)}</Sequence>"
        return f"<{tag}{attributes}{self.conditions(scope, calm=calm)}>{child}</{tag}>"

    def subtree(self, depth: int, scope: Scope, calm: bool) -> str:
        name = f"T{len(self.trees)}"
        self.trees.append("")
        roll = self.rng.random()
        if roll < 0.25:
            given, inner = {"_autoremap": "true"}, Scope((*scope.names, "_d8"), own=False)
        elif roll < 0.7:
            given = {"d0": "{@d0}", "d3": "{=}", "i0": "{@i1}", "t0": "e", "t2": "{t0}"}
            inner = Scope(("d0", "d3", "i0", "t0", "t2", "@b0", "u0", "@u0", "x0", "@p0", "@d1", "@v0"))
        else:
            given, inner = (
                {},
                Scope(("d0", "i0", "t0", "@d0", "@i0", "@t0", "@b0", "u0", "@u0", "x0", "@p0", "_d9", "@v0")),
            )
        content = self.node(depth - 1, inner, calm)
        if "_autoremap" in given:
            # A private name: not the one outside.
            content = f"""<Sequence><Script code="_d8 := 2.5"/>{content}</Sequence>"""
        elif not given:
            begin = """<Script code="d0 := 4.5; i0 := 2; t0 := 'z'; u0 := 0.0; x0 := 1.0"/>"""
            content = f"<Sequence>{begin}{content}</Sequence>"
        # A parameter that a tree does not use is an error here.
        used = [
            each for each in given if each.startswith("_") or re.search(rf"(?<![@\w]){each}\b(?!=)", content)
        ]
        said = "".join(f' {each}="{given[each]}"' for each in used)
        self.trees[int(name[1:])] = f'<BehaviorTree ID="{name}">{content}</BehaviorTree>'
        return f'<SubTree ID="{name}"{said}{self.conditions(scope, calm=calm)}/>'


class PlainMaker(Maker):
    """Nodes alone: no scripts, no conditions, nothing on the blackboard."""

    def conditions(self, scope: Scope, before: bool = True, calm: bool = False) -> str:
        return ""

    def immediate(self, scope: Scope) -> str:
        if self.rng.random() < 0.3:
            return self.rng.choice(("<AlwaysSuccess/>", "<AlwaysFailure/>", '<Sleep msec="0"/>'))
        name = f"C{len(self.scripts)}"
        self.scripts[name] = "".join(self.rng.choices("SF", k=self.rng.randint(1, 5)))
        return f"<{name}/>"

    def decision(self, scope: Scope) -> str:
        condition = self.immediate(scope)
        return self.rng.choice((condition, condition, f"<Inverter>{condition}</Inverter>"))

    def skipper(self, scope: Scope) -> str:
        return self.leaf(scope, calm=False)

    def switch(self, depth: int, scope: Scope) -> str:
        return self.control(depth, scope)

    def decorator(self, depth: int, scope: Scope, calm: bool) -> str:
        tag = self.rng.choice(DECORATORS[:8])
        attributes = {
            "Repeat": f' num_cycles="{self.rng.choice((-1, 0, 1, 2, 3))}"',
            "RetryUntilSuccessful": f' num_attempts="{self.rng.choice((-1, 0, 1, 2, 3))}"',
            "RunOnce": self.rng.choice(("", ' then_skip="false"', ' then_skip="true"')),
            "Timeout": f' msec="{self.rng.choice((0, 1_000_000))}"',
        }.get(tag, "")
        return f"<{tag}{attributes}>{self.node(depth - 1, scope, calm)}</{tag}>"

    def subtree(self, depth: int, scope: Scope, calm: bool) -> str:
        name = f"T{len(self.trees)}"
        self.trees.append("")
        content = self.node(depth - 1, scope, calm)
        self.trees[int(name[1:])] = f'<BehaviorTree ID="{name}">{content}</BehaviorTree>'
        return f'<SubTree ID="{name}"/>'


def make_plain_trial(seed: int, depth: int = 4) -> Trial:
    rng = random.Random(seed)
    maker = PlainMaker(rng)
    root = maker.control(depth, MAIN) if rng.random() < 0.8 else maker.node(depth, MAIN)
    halts = frozenset(tick for tick in range(TICKS) if rng.random() < 0.15)
    return Trial(document(root, *maker.trees), maker.scripts, {}, halts)


def make_trial(seed: int, depth: int = 4, mixes: bool = True) -> Trial:
    rng = random.Random(seed)
    maker = Maker(rng, mixes)
    calm = rng.random() < 0.15
    root = maker.control(depth, MAIN, calm) if rng.random() < 0.8 else maker.node(depth, MAIN, calm)
    halts = frozenset(tick for tick in range(TICKS) if rng.random() < 0.15) if not calm else frozenset()
    if not calm and rng.random() < 0.5:
        what = rng.choice(("(k0 & 3)", "(k0 / 2) < 2 ? 1 : 2", "v0 == 1 ? 2 : 1"))
        root = f"<ReactiveSequence><Script code={quoteattr(f'v0 := {what}')}/>{root}</ReactiveSequence>"
    if rng.random() < 0.9:
        root = f"<Sequence><RunOnce><Sequence>{PRELUDE}</Sequence></RunOnce>{root}</Sequence>"
    if maker.halts_noticed and halts:
        # There, halting a whole tree runs `_onHalted` of every node, running or not; a node in it is halted as ever.
        maker.scripts["CH"] = "".join("F" if tick in halts else "S" for tick in range(TICKS))
        root, halts = f"<ReactiveSequence><CH/>{root}</ReactiveSequence>", frozenset()
    return Trial(document(root, *maker.trees), maker.scripts, maker.writes, halts)
