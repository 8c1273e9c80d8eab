"""Which box is which object from frame to frame, and whether it has been seen often enough to be one.

In the picture, not in the world: the camera process knows no odometry. An object's column is predicted with constant
velocity, since the robot's turning moves the whole picture, and its size with constant growth. Boxes are given to
predictions so that all of them together fit best (`assignment`): when two objects pass each other, what tells them
apart is their size, and a box that fits the other's column fits its size badly. The nearer hides the farther meanwhile;
what is hidden is waited for longer than what is merely missed.

A false box seldom comes back to the same place, so it never gets confirmed; a real one survives a few missed frames.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from target_nav.config import Config
from target_nav.detectors.assignment import assign
from target_nav.utils.distance import Box, clipping_of

MIN_HITS_FOR_VELOCITY = 2
TURN_SHARE_ONCE_TRACKED = 0.35
"""Of the largest turning rate: how wrong a predicted velocity may be."""
V_GATE_HEIGHTS = 0.5
"""A level camera keeps a thing at its height in the picture; clipping and jitter move it by less than this."""
HEIGHT_GATE_LN = 0.45
POSITION_GAIN = 0.6
VELOCITY_GAIN = 0.3
"""Alpha-beta gains; beta = alpha^2 / (2 - alpha) would be 0.26 (Benedict and Bordner, 1962)."""
SIZE_GAIN = 0.3
GROWTH_GAIN = 0.05
"""The same for the logarithm of the height, which changes slowly and jitters much."""
UNCONFIRMED_COAST_FRAMES = 1

EDGE_SIGMA_HEIGHTS = 0.03
"""Jitter of a box's place and size, of its height (measured: 2 to 5 %)."""
SIZE_SIGMA_LN = 0.05
WIDTH_WEIGHT = 0.5
"""A box's width jitters as its height does, and not independently of it."""
SIGMAS_AT_GATE = 2.5
"""A column at the edge of its gate counts as so many sigmas off."""
UNMATCHED_COST = 25.0
"""An object rather stays unseen than takes a box that fits worse than this, in squared sigmas."""
CUT_OFF_COST = 12.0
"""The most that size costs at the picture's border."""
HIDDEN_COAST_S = 3.0
SCREEN_MISSED = 2
"""What hides it may itself be missed for so many frames."""
TELL_APART_LN = 0.15
"""Two of more like sizes would be taken for each other when they part again: a new id is better than a wrong one."""
HIDDEN_SHARE = 0.3
"""An object counts as hidden when so much of it lies behind a taller, so nearer one."""


@dataclass
class TrackedBox:
    """One object. `missed` counts the frames since it was last seen; sizes are smoothed logarithms of pixels."""

    track_id: int
    box: Box
    u_px: float
    height_ln: float
    width_ln: float
    u_rate_px: float = 0.0
    growth_ln: float = 0.0
    hits: int = 1
    missed: int = 0
    unseen_s: float = 0.0
    confirmed: bool = False

    @classmethod
    def begin(cls, track_id: int, box: Box, confirmed: bool) -> TrackedBox:
        sizes = math.log(box.height_px), math.log(box.width_px)
        return cls(track_id, box, box.u_px, *sizes, confirmed=confirmed)

    def hides(self, other: TrackedBox) -> bool:
        """It stands nearer than `other`, in front of a good part of it."""
        if self.height_ln < other.height_ln + TELL_APART_LN:
            return False
        reach_px = 0.5 * (self.box.width_px + other.box.width_px)
        covered_px = reach_px - abs(self.u_px - other.u_px)
        return covered_px > HIDDEN_SHARE * other.box.width_px


class BoxTracker:
    """`update` once a frame; ids count up from 1 and are never given twice."""

    def __init__(self, config: Config) -> None:
        self._confirm_frames = config.detector.confirm_frames
        self._coast_frames = config.detector.coast_frames
        self._turn_px = config.camera.focal_px * config.robot.max_yaw_rate_radps
        self._camera, self._border_px = config.camera, config.detector.border_px
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
        chosen = assign([self._costs(track, dt_s, boxes) for track in self._tracks], UNMATCHED_COST)
        for track, index in zip(self._tracks, chosen):
            if index is not None:
                owners[index] = track
                self._correct(track, boxes[index], dt_s)
            else:
                track.missed += 1
                track.unseen_s += dt_s
                track.u_px += track.u_rate_px * dt_s
        self._tracks = [track for track in self._tracks if self._lasts(track)]
        return [owner if owner is not None else self._start(boxes[i]) for i, owner in enumerate(owners)]

    def _costs(self, track: TrackedBox, dt_s: float, boxes: list[Box]) -> list[float]:
        """How badly each box fits, in squared sigmas; inf outside of the gate."""
        u_px = track.u_px + track.u_rate_px * dt_s
        share = TURN_SHARE_ONCE_TRACKED if track.hits >= MIN_HITS_FOR_VELOCITY else 1.0
        gate_u_px = track.box.width_px + share * self._turn_px * dt_s * (1 + track.missed)
        gate_v_px = V_GATE_HEIGHTS * track.box.height_px
        sigma_u_px = math.hypot(EDGE_SIGMA_HEIGHTS * track.box.height_px, gate_u_px / SIGMAS_AT_GATE)
        growth_ln = track.growth_ln * (dt_s + track.unseen_s)
        costs = []
        for box in boxes:
            off_u_px, off_v_px = abs(box.u_px - u_px), abs(box.v_px - track.box.v_px)
            off_height_ln = math.log(box.height_px / track.box.height_px)
            if off_u_px > gate_u_px or off_v_px > gate_v_px or abs(off_height_ln) > HEIGHT_GATE_LN:
                costs.append(math.inf)
                continue
            height_ln = (math.log(box.height_px) - track.height_ln - growth_ln) / SIZE_SIGMA_LN
            width_ln = (math.log(box.width_px) - track.width_ln - growth_ln) / SIZE_SIGMA_LN
            sizes = height_ln * height_ln + WIDTH_WEIGHT * width_ln * width_ln
            if self._at_border(box) or self._at_border(track.box):
                # It is being cut off: size still tells two apart, it does not rule one out.
                sizes = min(sizes, CUT_OFF_COST)
            costs.append((off_u_px / sigma_u_px) ** 2 + sizes)
        return costs

    def _at_border(self, box: Box) -> bool:
        return clipping_of(self._camera, box, self._border_px).any

    def _correct(self, track: TrackedBox, box: Box, dt_s: float) -> None:
        predicted_px = track.u_px + track.u_rate_px * dt_s
        error_px = box.u_px - predicted_px
        if track.hits < MIN_HITS_FOR_VELOCITY:
            track.u_rate_px = error_px / dt_s
            track.u_px = box.u_px
        else:
            track.u_px = predicted_px + POSITION_GAIN * error_px
            track.u_rate_px += VELOCITY_GAIN * error_px / dt_s
        elapsed_s = dt_s + track.unseen_s
        if self._at_border(track.box):
            # What was cut off says little about size: begin with this box.
            track.height_ln, track.width_ln = math.log(box.height_px), math.log(box.width_px)
            track.growth_ln = 0.0
        growth_ln = track.growth_ln * elapsed_s
        surprise_ln = math.log(box.height_px) - track.height_ln - growth_ln
        track.height_ln += growth_ln + SIZE_GAIN * surprise_ln
        track.width_ln += growth_ln + SIZE_GAIN * (math.log(box.width_px) - track.width_ln - growth_ln)
        track.growth_ln += GROWTH_GAIN * surprise_ln / elapsed_s
        track.box = box
        track.hits += 1
        track.missed = 0
        track.unseen_s = 0.0
        track.confirmed = track.confirmed or track.hits >= self._confirm_frames

    def _lasts(self, track: TrackedBox) -> bool:
        """Whether an object is still waited for."""
        if track.missed == 0:
            return True
        if not track.confirmed:
            return track.missed <= min(UNCONFIRMED_COAST_FRAMES, self._coast_frames)
        if track.missed <= self._coast_frames:
            return True
        hidden = any(other.missed <= SCREEN_MISSED and other.hides(track) for other in self._tracks)
        return hidden and track.unseen_s <= HIDDEN_COAST_S

    def _start(self, box: Box) -> TrackedBox:
        track = TrackedBox.begin(self._next_id, box, self._confirm_frames <= 1)
        self._next_id += 1
        self._tracks.append(track)
        return track
