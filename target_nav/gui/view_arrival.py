"""How near the end is: distance from the front edge to the target's surface, what is left of it, how it ended."""

from __future__ import annotations

import math
from dataclasses import dataclass

from target_nav.config import Config
from target_nav.gui.source import World
from target_nav.state.target_label import surface_m
from target_nav.state.types import OutcomeKind


@dataclass(frozen=True)
class ArrivalView:
    """`gap_m` is front edge to target surface, `left_m` what of it is more than the stand-off; NaN without a target.

    `progress` goes from 0 (where blind approach begins) to 1 (at the stand-off); `seen_s` is the target's age.
    """

    done: bool
    succeeded: bool
    title: str
    reason: str
    gap_m: float
    stand_off_m: float
    left_m: float
    bearing_rad: float
    sigma_m: float
    progress: float
    seen_s: float
    ranged_s: float
    fresh: bool


def arrival_view(world: World, config: Config) -> ArrivalView:
    nav = world.nav.value
    outcome = nav.outcome if nav is not None else None
    track = nav.track if nav is not None else None
    gap = bearing = sigma = math.nan
    seen_s = ranged_s = math.inf
    stand_off_m = config.approach.stand_off_m
    if nav is not None and track is not None:
        gap = track.range_m - config.robot.front_m - surface_m(nav.spec.class_name, nav.spec.width_m)
        bearing, sigma = track.bearing_rad, track.sigma_m
        seen_s, ranged_s = world.now_s - track.last_seen_s, world.now_s - track.last_ranged_s
    begin_m = max(config.approach.blind_from_m - config.robot.front_m - stand_off_m, 0.1)
    left_m = gap - stand_off_m
    succeeded = outcome is not None and outcome.kind is OutcomeKind.SUCCEEDED
    return ArrivalView(
        done=outcome is not None,
        succeeded=succeeded,
        title="" if outcome is None else "ARRIVED" if succeeded else "GAVE UP",
        reason=outcome.reason if outcome is not None else "",
        gap_m=gap,
        stand_off_m=stand_off_m,
        left_m=left_m,
        bearing_rad=bearing,
        sigma_m=sigma,
        progress=1.0
        if succeeded
        else min(max(1.0 - left_m / begin_m, 0.0), 1.0)
        if left_m == left_m
        else 0.0,
        seen_s=seen_s,
        ranged_s=ranged_s,
        fresh=world.nav.fresh,
    )
