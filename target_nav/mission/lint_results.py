"""What each node of a mission can return at all, and which nodes can therefore never be ticked.

An over-estimate: a result that a node may have is never left out, so what is called unreachable is. Keys, time and
what leaves do are not known; the structure is, and a few nodes whose result their name says.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from behaviours.standing import StandingLeaf
from target_nav.mission.expand import Instance
from target_nav.mission.problems import Report

SUCCESS, FAILURE, RUNNING, SKIPPED = "success", "failure", "running", "skipped"
Results = frozenset[str]

EVERYTHING: Results = frozenset((SUCCESS, FAILURE, RUNNING, SKIPPED))
_LEAF: Results = frozenset((SUCCESS, FAILURE, RUNNING))
_OPPOSITE = {SUCCESS: FAILURE, FAILURE: SUCCESS}

_SEQUENCES = ("Sequence", "AsyncSequence", "SequenceWithMemory", "ReactiveSequence")
_FALLBACKS = ("Fallback", "AsyncFallback", "ReactiveFallback")
_LEAVES: dict[str, Results] = {
    "AlwaysSuccess": frozenset((SUCCESS,)),
    "AlwaysFailure": frozenset((FAILURE,)),
    "Sleep": frozenset((RUNNING, SUCCESS)),
    "Script": frozenset((SUCCESS,)),
    "UnsetBlackboard": frozenset((SUCCESS,)),
    "SetBlackboard": frozenset((SUCCESS, FAILURE)),
    "ScriptCondition": frozenset((SUCCESS, FAILURE)),
    "WasEntryUpdated": frozenset((SUCCESS, FAILURE)),
}
_CONDITIONS = {"_failureIf": FAILURE, "_successIf": SUCCESS, "_skipIf": SKIPPED, "_while": SKIPPED}


def check_reachability(root: Instance, report: Report) -> None:
    """Warns of every node that is never ticked, at the first of a row of them."""
    for instances, why in Reachability(root).unreachable:
        first, others = instances[0].definition, len(instances) - 1
        more = f", nor {'is the one' if others == 1 else f'are the {others}'} after it" if others else ""
        report.warning(first.position, f"{first.id} is never ticked{more}: {why}")


class Reachability:
    """What is found: `results` of each node that can be reached, and the siblings that cannot, with the reason."""

    def __init__(self, root: Instance) -> None:
        self.results: dict[Instance, Results] = {}
        self.unreachable: list[tuple[Sequence[Instance], str]] = []
        self._decorators: dict[str, Callable[[Instance], Results]] = {
            "Inverter": lambda it: frozenset(_OPPOSITE.get(each, each) for each in self._child(it)),
            "ForceSuccess": lambda it: self._forced(it, SUCCESS),
            "ForceFailure": lambda it: self._forced(it, FAILURE),
            "RetryUntilSuccessful": lambda it: self._counting(it, "num_attempts", FAILURE),
            "Repeat": lambda it: self._counting(it, "num_cycles", SUCCESS),
            "KeepRunningUntilFailure": lambda it: (self._child(it) & {FAILURE}) | {RUNNING},
            "RunOnce": lambda it: self._child(it) | {SKIPPED},
            "Delay": lambda it: self._child(it) | {RUNNING},
            "Timeout": self._timeout,
            "SkipUnlessUpdated": lambda it: self._child(it) | {SKIPPED},
            "WaitValueUpdate": lambda it: self._child(it) | {RUNNING},
        }
        self._results(root)

    def _results(self, instance: Instance) -> Results:
        said = {_CONDITIONS[each.name] for each in instance.definition.attributes if each.name in _CONDITIONS}
        results = self.results[instance] = self._own(instance) | said
        return results

    def _own(self, instance: Instance) -> Results:
        id_, children = instance.definition.id, instance.children
        if instance.spec is None:
            # a SubTree, or a node nobody knows
            return (
                self._child(instance) if instance.definition.is_subtree and children else self._all(instance)
            )
        if not children:
            if issubclass(instance.spec.cls, StandingLeaf):
                return frozenset((RUNNING,))
            return _LEAVES.get(id_, _LEAF)
        if id_ in _SEQUENCES:
            return self._in_order(instance, children, SUCCESS)
        if id_ in _FALLBACKS:
            return self._in_order(instance, children, FAILURE)
        if id_ in ("IfThenElse", "WhileDoElse"):
            return self._branching(instance)
        if id_ == "TryCatch":
            return self._try_catch(instance)
        decorator = self._decorators.get(id_)
        return decorator(instance) if decorator is not None else self._all(instance)

    def _all(self, instance: Instance) -> Results:
        for child in instance.children:
            self._results(child)
        return EVERYTHING

    def _child(self, instance: Instance) -> Results:
        return self._results(instance.children[0])

    # -- control nodes -----------------------------------------------------------------------------------------------

    def _in_order(self, parent: Instance, children: Sequence[Instance], goes_on: str) -> Results:
        found: set[str] = set()
        skipped = 0
        for index, child in enumerate(children):
            results = self._results(child)
            found |= results - {goes_on, SKIPPED}
            skipped += SKIPPED in results
            if not results & {goes_on, SKIPPED}:
                self._unreachable(children[index + 1 :], f"{_name(child)} before it {_behaves(results)}")
                return frozenset(found)
        found.add(goes_on)
        if skipped == len(children):
            found.add(SKIPPED)
        return frozenset(found)

    def _branching(self, instance: Instance) -> Results:
        condition, *branches = instance.children
        results = self._results(condition)
        found = set(results & {RUNNING})
        for branch, answer in zip(branches, (SUCCESS, FAILURE)):
            if answer in results:
                found |= self._results(branch)
            else:
                self._unreachable([branch], f"its condition {_name(condition)} {_behaves(results)}")
        if len(branches) == 1:
            found |= results & {FAILURE}
        return frozenset(found)

    def _try_catch(self, instance: Instance) -> Results:
        *tried, catch = instance.children
        results = self._in_order(instance, tried, SUCCESS)
        on_halt = instance.definition.attribute("catch_on_halt") is not None
        if FAILURE in results or (on_halt and instance.literals.get("catch_on_halt") is not False):
            return results | (self._results(catch) & {RUNNING})
        self._unreachable([catch], "nothing before it fails")
        return results

    # -- decorators --------------------------------------------------------------------------------------------------

    def _forced(self, instance: Instance, result: str) -> Results:
        return frozenset(result if each in _OPPOSITE else each for each in self._child(instance))

    def _counting(self, instance: Instance, port: str, counted: str) -> Results:
        times = instance.literals.get(port)
        if times == 0:
            self._unreachable(instance.children, f"{port} is 0")
            return frozenset((counted,))
        results = self._child(instance)
        return (results - {counted}) | {RUNNING} if times == -1 else results | {RUNNING}

    def _timeout(self, instance: Instance) -> Results:
        results = self._child(instance)
        return results | {FAILURE} if RUNNING in results and instance.literals.get("msec") != 0 else results

    def _unreachable(self, instances: Sequence[Instance], why: str) -> None:
        if instances:
            self.unreachable.append((instances, why))


def _name(instance: Instance) -> str:
    return instance.definition.id


def _behaves(results: Results) -> str:
    ends = results & {SUCCESS, FAILURE}
    if not ends:
        return "never ends"
    if results == {SUCCESS}:
        return "always succeeds"
    if results == {FAILURE}:
        return "always fails"
    return "never fails" if ends == {SUCCESS} else "never succeeds"
