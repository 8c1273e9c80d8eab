"""The bar at the top: what the robot does, how old each of its senses is, who is dead, how well the loop keeps time."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache

from target_nav.config import Config
from target_nav.gui.source import World, age_text
from target_nav.state.live_settings import fingerprint
from target_nav.state.types import OutcomeKind

FINE_CONDITIONS = frozenset({"running", "exited", "waiting", "starting"})

STATE_TEXT = {
    "IDLE": "IDLE",
    "NAVIGATING": "NAVIGATING",
    "SEARCHING": "SEARCHING",
    "SPIRAL_SEARCH": "SPIRAL SEARCH",
    "BLIND_APPROACH": "BLIND APPROACH",
    "ARRIVED": "ARRIVED",
}


@dataclass(frozen=True)
class LinkView:
    """One source. `label` is a word for a small screen, `text` its age, `problem` what is wrong in a sentence.

    `quiet`: it is silent because nobody drives, which is as it should be: the firmware tells odometry only then.
    """

    name: str
    label: str
    age_s: float
    limit_s: float
    fresh: bool
    text: str
    problem: str
    quiet: bool = False


@dataclass(frozen=True)
class StatusView:
    """`headline` is what is read from two metres; `banner` is what is wrong, empty when nothing is."""

    headline: str
    state: str
    mission: str
    target: str
    leaf: str
    reason: str
    requested: bool
    paused: bool
    manual: bool
    outcome: str
    outcome_reason: str
    limited_by: str
    speed_mps: float
    yaw_rate_radps: float
    rate_hz: float
    lateness_p99_s: float
    overruns: int
    links: tuple[LinkView, ...]
    dead: tuple[str, ...]
    notice: str
    notice_count: int
    settings_differ: bool
    """The nav process uses other values than this screen shows."""
    banner: str
    fresh: bool


def status_view(world: World, config: Config) -> StatusView:
    nav, fresh = world.nav.value, world.nav.fresh
    links = link_views(world, config)
    dead = dead_processes(world)
    outcome = nav.outcome if nav is not None else None
    headline = "NO CONTACT" if nav is None else STATE_TEXT.get(nav.state.name, nav.state.name)
    if nav is not None:
        if nav.manual:
            headline = "MANUAL"
        elif outcome is not None and outcome.kind is OutcomeKind.FAILED:
            headline = "GAVE UP"
        elif nav.paused:
            headline = f"{headline} (PAUSED)"
    return StatusView(
        headline=headline,
        state=nav.state.name if nav is not None else "",
        mission=nav.mission if nav is not None else "",
        target=nav.spec.class_name.replace("_", " ") if nav is not None else "",
        leaf=nav.running_leaf if nav is not None else "",
        reason=nav.reason if nav is not None else "",
        requested=nav.requested if nav is not None else False,
        paused=nav.paused if nav is not None else False,
        manual=nav.manual if nav is not None else False,
        outcome=outcome.kind.value if outcome is not None else "",
        outcome_reason=outcome.reason if outcome is not None else "",
        limited_by=nav.limited_by if nav is not None else "",
        speed_mps=nav.twist_sent.speed_mps if nav is not None else 0.0,
        yaw_rate_radps=nav.twist_sent.wz_radps if nav is not None else 0.0,
        rate_hz=nav.rate_hz if nav is not None else 0.0,
        lateness_p99_s=nav.jitter_p99_s if nav is not None else 0.0,
        overruns=nav.overruns if nav is not None else 0,
        links=links,
        dead=dead,
        notice=nav.notice if nav is not None else "",
        notice_count=nav.notice_count if nav is not None else 0,
        settings_differ=fresh and nav is not None and nav.settings_crc != _crc(config),
        banner=_banner(world, links, dead),
        fresh=fresh,
    )


def link_views(world: World, config: Config) -> tuple[LinkView, ...]:
    """Nav process, LiDAR, odometry, detections, pictures, tree; in this order. Ages count from when it was taken."""
    nav = world.nav.value
    since_s = world.now_s - nav.stamp_s if nav is not None else math.inf
    loop = config.loop
    scan_s = nav.scan_age_s + since_s if nav is not None else math.inf
    odom_s = nav.odom_age_s + since_s if nav is not None else math.inf
    told = world.nav.excuse
    return (
        _link("nav", "nav", world.nav.age_s, world.nav.limit_s, world.nav.excuse),
        _link("scan", "LiDAR", scan_s, loop.scan_max_age_s, told or "no scan; is the LiDAR running?"),
        _odometry(world, odom_s, loop.odom_max_age_s, told),
        _link("det", "boxes", world.det.age_s, world.det.limit_s, world.det.excuse),
        _link("camera", "image", world.camera.age_s, world.camera.limit_s, world.camera.excuse),
        _link("tree", "tree", world.tree.age_s, world.tree.limit_s, world.tree.excuse),
    )


def dead_processes(world: World) -> tuple[str, ...]:
    """By name: those the supervisor says are down, and those that have let go of their channels."""
    dead = list(world.gone)
    table = world.processes.value
    if table is not None and world.processes.fresh:
        dead += [row.name for row in table.rows if row.condition not in FINE_CONDITIONS]
    return tuple(dict.fromkeys(dead))


def _link(name: str, label: str, age_s: float, limit_s: float, problem: str) -> LinkView:
    # NaN counts as stale
    fresh = bool(age_s <= limit_s)
    return LinkView(name, label, age_s, limit_s, fresh, age_text(age_s), "" if fresh else problem)


def _odometry(world: World, age_s: float, limit_s: float, told: str) -> LinkView:
    nav = world.nav.value
    drives = nav is None or (nav.requested and nav.outcome is None) or nav.manual
    link = _link("odom", "odom", age_s, limit_s, told or "no odometry; is the arduino node running?")
    if link.fresh or drives or not world.nav.fresh:
        return link
    return replace(link, text="quiet", problem="", quiet=True)


@lru_cache(maxsize=2)
def _crc(config: Config) -> int:
    return fingerprint(config)


def _banner(world: World, links: tuple[LinkView, ...], dead: tuple[str, ...]) -> str:
    if dead:
        return f"process {', '.join(dead)} is down"
    stale = [link for link in links if not link.fresh and not link.quiet]
    return stale[0].problem if stale else ""
