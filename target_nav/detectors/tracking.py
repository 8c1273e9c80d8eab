"""Which box is which object from frame to frame, and whether it has been seen often enough to be one.

In the picture, not in the world: the camera process knows no odometry. An object's column is predicted with constant
velocity, since the robot's turning moves the whole picture; boxes are given to predictions nearest first, inside a
gate. A false box seldom comes back to the same place, so it never gets confirmed; a real one survives a few missed
frames.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from target_nav.config import Config
from target_nav.utils.distance import Box

MIN_HITS_FOR_VELOCITY = 2
TURN_SHARE_ONCE_TRACKED = 0.35
"""Of the largest turning rate: how wrong a predicted velocity may be."""
V_GATE_HEIGHTS = 0.5
"""A level camera keeps a thing at its height in the picture; clipping and jitter move it by less than this."""
HEIGHT_GATE_LN = 0.45
POSITION_GAIN = 0.6
VELOCITY_GAIN = 0.3
"""Alpha-beta gains; beta = alpha^2 / (2 - alpha) would be 0.26 (Benedict and Bordner, 1962)."""
UNCONFIRMED_COAST_FRAMES = 1


@dataclass
class TrackedBox:
    """One object. `missed` counts the frames since it was last seen."""

    track_id: int
    box: Box
    u_px: float
    u_rate_px: float = 0.0
    hits: int = 1
    missed: int = 0
    confirmed: bool = False


class BoxTracker:
    """`update` once a frame; ids count up from 1 and are never given twice."""

    def __init__(self, config: Config) -> None:
        self._confirm_frames = config.detector.confirm_frames
        self._coast_frames = config.detector.coast_frames
        self._turn_px = config.camera.focal_px * config.robot.max_yaw_rate_radps
        self._max_gap_s = config.loop.camera_max_age_s
        self._tracks: list[TrackedBox] = []
        self._last_stamp_s = -math.inf
        self._next_id = 1

    @property
    def tracks(self) -> tuple[TrackedBox, ...]:
        """All objects, those out of sight for a few frames included."""
        return tuple(self._tracks)

    def reset(self) -> None:
        """Forget all objects (another target, or the pictures had stopped)."""
        self._tracks.clear()

    def update(self, stamp_s: float, boxes: list[Box]) -> list[TrackedBox]:
        """The object of each box, in the order of `boxes`."""
        dt_s = stamp_s - self._last_stamp_s
        self._last_stamp_s = stamp_s
        if dt_s > self._max_gap_s:
            self.reset()
        owners: list[TrackedBox | None] = [None] * len(boxes)
        seen: set[int] = set()
        for _, track, index in sorted(self._pairs(dt_s, boxes), key=_by_cost):
            if owners[index] is None and track.track_id not in seen:
                owners[index] = track
                seen.add(track.track_id)
                self._correct(track, boxes[index], dt_s)
        for track in self._tracks:
            if track.track_id not in seen:
                track.missed += 1
                track.u_px += track.u_rate_px * dt_s
        self._tracks = [track for track in self._tracks if track.missed <= self._allowed_misses(track)]
        return [owner if owner is not None else self._start(boxes[i]) for i, owner in enumerate(owners)]

    def _pairs(self, dt_s: float, boxes: list[Box]) -> list[tuple[float, TrackedBox, int]]:
        """Every (cost, object, index of box) inside the gate; cost 1 is its edge in one of the three measures."""
        pairs = []
        for track in self._tracks:
            u_px = track.u_px + track.u_rate_px * dt_s
            share = TURN_SHARE_ONCE_TRACKED if track.hits >= MIN_HITS_FOR_VELOCITY else 1.0
            gate_u_px = track.box.width_px + share * self._turn_px * dt_s * (1 + track.missed)
            gate_v_px = V_GATE_HEIGHTS * track.box.height_px
            for index, box in enumerate(boxes):
                u_cost = abs(box.u_px - u_px) / gate_u_px
                v_cost = abs(box.v_px - track.box.v_px) / gate_v_px
                if u_cost > 1.0 or v_cost > 1.0:
                    continue
                h_cost = abs(math.log(box.height_px / track.box.height_px)) / HEIGHT_GATE_LN
                if h_cost <= 1.0:
                    pairs.append((u_cost * u_cost + v_cost * v_cost + h_cost * h_cost, track, index))
        return pairs

    def _correct(self, track: TrackedBox, box: Box, dt_s: float) -> None:
        predicted_px = track.u_px + track.u_rate_px * dt_s
        error_px = box.u_px - predicted_px
        if track.hits < MIN_HITS_FOR_VELOCITY:
            track.u_rate_px = error_px / dt_s
            track.u_px = box.u_px
        else:
            track.u_px = predicted_px + POSITION_GAIN * error_px
            track.u_rate_px += VELOCITY_GAIN * error_px / dt_s
        track.box = box
        track.hits += 1
        track.missed = 0
        track.confirmed = track.confirmed or track.hits >= self._confirm_frames

    def _allowed_misses(self, track: TrackedBox) -> int:
        return self._coast_frames if track.confirmed else min(UNCONFIRMED_COAST_FRAMES, self._coast_frames)

    def _start(self, box: Box) -> TrackedBox:
        track = TrackedBox(self._next_id, box, box.u_px, confirmed=self._confirm_frames <= 1)
        self._next_id += 1
        self._tracks.append(track)
        return track


def _by_cost(pair: tuple[float, TrackedBox, int]) -> float:
    return pair[0]
