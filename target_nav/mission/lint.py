"""What is allowed in a mission and yet hardly meant: told by `target-nav check` as warnings, never by the loader."""

from __future__ import annotations

from behaviours.approach import ApproachFrom
from target_nav.mission.check import Analysis
from target_nav.mission.expand import Instance
from target_nav.mission.lint_results import check_reachability
from target_nav.mission.problems import Problem, Report, TooManyProblems
from target_nav.mission.wiring import traffic_of
from target_nav.state import keys
from target_nav.state.target_label import TargetDetector
from target_nav.state.types import NavState

SEARCHING = (NavState.SEARCHING, NavState.SPIRAL_SEARCH)
LIMIT_PORTS = ("time_limit_s", "timeout_s")


def lint(analysis: Analysis, tick_s: float) -> list[Problem]:
    """Warnings beside those of the check, in the order of reading. `tick_s` is the time from tick to tick."""
    report = Report()
    if analysis.root is not None:
        try:
            check_reachability(analysis.root, report)
            _keys_are_read(analysis.root, report)
            _searches_end(analysis.root, False, report)
            _timeouts_are_ticks(analysis.root, tick_s, report)
            _faces_are_known(analysis.root, report)
        except TooManyProblems:
            pass
    return report.problems()


def _keys_are_read(root: Instance, report: Report) -> None:
    table = {key.name for key in keys.ALL}
    touched = {path for instance in root.walk() for path in instance.touched}
    for path, uses in traffic_of(root).items():
        if uses.readers or path in table or path in touched:
            continue
        for instance, use in uses.writers:
            report.warning(
                use.position,
                f"{instance.definition.id}: {use.port} writes {use.text.strip()} ({path}), which nobody reads",
            )


def _searches_end(instance: Instance, limited: bool, report: Report) -> None:
    """A search is limited by a port of its own or by a Timeout somewhere above it."""
    definition = instance.definition
    if definition.id == "Timeout" and instance.literals.get("msec") != 0:
        limited = True
    if not limited and instance.spec is not None and getattr(instance.spec.cls, "STATE", None) in SEARCHING:
        ports = [port for port in LIMIT_PORTS if port in instance.spec.inputs]
        if not any(definition.attribute(port) for port in ports):
            own = f"give it {' or '.join(ports)}, or put it" if ports else "put it"
            default = "; without, the robot's configuration decides" if ports else ""
            report.warning(
                definition.position, f"{definition.id} has no time limit; {own} into a Timeout{default}"
            )
    for child in instance.children:
        _searches_end(child, limited, report)


def _timeouts_are_ticks(root: Instance, tick_s: float, report: Report) -> None:
    for instance in root.walk():
        msec = instance.literals.get("msec")
        if instance.definition.id == "Timeout" and msec is not None and 0 < msec <= 1000.0 * tick_s:
            where = instance.definition.attribute("msec")
            report.warning(
                where.position if where is not None else instance.definition.position,
                f"Timeout: msec is {msec}; a tick takes {1000.0 * tick_s:g} ms, so its child gets one tick only",
            )


def _faces_are_known(root: Instance, report: Report) -> None:
    """`from="face"` says something only of a target whose detector knows where its face looks."""
    nodes = list(root.walk())
    targets = [node for node in nodes if node.definition.id == "SetTarget"]
    if any(node.definition.attribute("detector") and "detector" not in node.literals for node in targets):
        return  # an entry says which
    names = {TargetDetector(node.literals.get("detector", TargetDetector.network)).value for node in targets}
    if not names or TargetDetector.apriltag.value in names:
        return
    for node in nodes:
        where = node.definition.attribute("from")
        asked = node.definition.id == "NavigateToTarget" and node.literals.get("from") == ApproachFrom.face
        if where is not None and asked:
            report.warning(
                where.position,
                f'NavigateToTarget: from="face", but the target of this mission ({", ".join(sorted(names))}) has none '
                f'that is known, so it goes the short way; set detector="{TargetDetector.apriltag.value}", or leave '
                "it out",
            )
