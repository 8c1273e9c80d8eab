"""The camera process's pipeline: what it lets through, what it refuses and counts, and where it places things."""

from __future__ import annotations

import math
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from target_nav.detectors.pipeline import DetectionPipeline
from target_nav.errors import StaleInput
from target_nav.state.types import Detection, RawDetection, RawDetectionFrame, TargetSpec
from target_nav.utils.distance import Box
from tests.unit.detectors.boxes import CONFIG, PIN, frame, raw, raw_at

CONFIRM = CONFIG.detector.confirm_frames


def feed(
    pipeline: DetectionPipeline, *detections: RawDetection, frames: int = 1, start: int = 0
) -> tuple[Detection, ...]:
    """The objects of the last of so many equal frames."""
    result: tuple[Detection, ...] = ()
    for k in range(frames):
        result = pipeline.process(frame(start + k, *detections), PIN).detections
    return result


@given(st.floats(0.4, 7.0), st.floats(-0.4, 0.4))
def test_a_pin_is_placed_where_it_stands(range_m: float, bearing_rad: float) -> None:
    (detection,) = feed(DetectionPipeline(CONFIG), raw_at(range_m, bearing_rad))
    assert not detection.clipped
    assert detection.range_m == pytest.approx(range_m, rel=1e-9)
    assert detection.bearing_rad == pytest.approx(bearing_rad, abs=1e-9)
    assert 0.034 * range_m <= detection.range_sigma_m <= 0.0435 * range_m
    assert math.radians(0.4) <= detection.bearing_sigma_rad <= math.radians(1.0)


def test_the_target_s_size_scales_the_range() -> None:
    box = raw_at(2.0)
    half = TargetSpec("bowling_pin", PIN.height_m / 2, PIN.width_m / 2)
    (detection,) = DetectionPipeline(CONFIG).process(frame(0, box), half).detections
    assert detection.range_m == pytest.approx(1.0)


def test_stamp_and_frame_id_are_those_of_the_picture() -> None:
    result = DetectionPipeline(CONFIG).process(RawDetectionFrame(123.25, 77), PIN)
    assert (result.stamp_s, result.frame_id, result.detections) == (123.25, 77, ())


@pytest.mark.parametrize("range_m", [0.6, 1.0, 2.0, 4.0])
def test_the_sigmas_are_honest(range_m: float) -> None:
    """Errors over sigmas, for boxes that jitter by 3 % of their height and a mount off by up to 0.8 degrees: about
    one in the mean, never far over it."""
    rng = np.random.default_rng(8)
    ranges, bearings = [], []
    for _ in range(400):
        bearing_rad = float(rng.uniform(-0.35, 0.35))
        seen = raw_at(range_m, bearing_rad + float(rng.uniform(-0.014, 0.014)))
        jitter_px = 0.03 * seen.height_px
        shaken = replace(
            seen,
            u_px=seen.u_px + float(rng.normal(0.0, 0.5 * jitter_px)),
            height_px=seen.height_px + float(rng.normal(0.0, jitter_px)),
        )
        (found,) = feed(DetectionPipeline(CONFIG), shaken)
        ranges.append((found.range_m - range_m) / found.range_sigma_m)
        bearings.append((found.bearing_rad - bearing_rad) / found.bearing_sigma_rad)
    assert 0.5 < float(np.std(ranges)) < 1.1
    assert 0.5 < float(np.std(bearings)) < 1.1


class TestLayers:
    def test_every_box_is_counted_once(self) -> None:
        pipeline = DetectionPipeline(CONFIG)
        low = raw_at(1.0, 0.3, score=CONFIG.detector.score_min - 0.01)
        square = raw(Box(100.0, 240.0, 80.0, 80.0))
        bottle = raw_at(1.5, -0.3, spec=TargetSpec("bottle", 0.25, 0.07))
        broken = RawDetection("bowling_pin", math.nan, 1.0, 1.0, 1.0, 1.0)
        for k in range(CONFIRM):
            pipeline.process(frame(k, raw_at(1.0), low, square, bottle, broken), PIN)
        counts = pipeline.counters.as_dict()
        assert counts == {
            "frames": CONFIRM,
            "boxes": 5 * CONFIRM,
            "malformed": CONFIRM,
            "other_class": CONFIRM,
            "low_score": CONFIRM,
            "wrong_shape": CONFIRM,
            "unconfirmed": CONFIRM - 1,
            "confirmed": 1,
            "clipped": 0,
        }

    @pytest.mark.parametrize(
        "change",
        [
            {"u_px": math.nan},
            {"height_px": math.inf},
            {"width_px": 0.0},
            {"height_px": -5.0},
            {"score": 1.5},
            {"u_px": -1.0},
            {"v_px": 481.0},
        ],
    )
    def test_nonsense_is_refused(self, change: dict[str, float]) -> None:
        pipeline = DetectionPipeline(CONFIG)
        assert feed(pipeline, replace(raw_at(1.0), **change)) == ()
        assert pipeline.counters.malformed == 1

    def test_the_score_s_limit_belongs_to_what_passes(self) -> None:
        assert feed(DetectionPipeline(CONFIG), raw_at(1.0, score=CONFIG.detector.score_min))

    @given(st.floats(0.2, 5.0))
    def test_shape_is_judged_by_the_logarithm_of_width_to_height(self, factor: float) -> None:
        box = raw_at(1.5)
        stretched = replace(box, width_px=box.width_px * factor)
        accepted = bool(feed(DetectionPipeline(CONFIG), stretched))
        if abs(abs(math.log(factor)) - CONFIG.detector.aspect_tolerance) > 1e-6:
            assert accepted == (abs(math.log(factor)) < CONFIG.detector.aspect_tolerance)

    def test_a_box_that_lost_its_foot_may_look_too_wide_but_not_too_slim(self) -> None:
        cut = Box.from_edges(280.0, 330.0, 360.0, 480.0)  # 80 px wide, 150 of 280 px high
        assert feed(DetectionPipeline(CONFIG), raw(cut))
        slim = Box.from_edges(300.0, 100.0, 320.0, 480.0)
        assert feed(DetectionPipeline(CONFIG), raw(slim)) == ()

    def test_a_box_cut_at_the_side_may_look_too_slim_but_not_too_wide(self) -> None:
        cut = Box.from_edges(0.0, 140.0, 30.0, 340.0)  # 30 of 57 px wide
        assert feed(DetectionPipeline(CONFIG), raw(cut))
        wide = Box.from_edges(0.0, 140.0, 120.0, 340.0)
        assert feed(DetectionPipeline(CONFIG), raw(wide)) == ()

    def test_an_object_counts_after_some_frames(self) -> None:
        pipeline = DetectionPipeline(CONFIG)
        confirmed = [feed(pipeline, raw_at(1.0), start=k)[0].confirmed for k in range(CONFIRM + 2)]
        assert confirmed == [False] * (CONFIRM - 1) + [True] * 3

    def test_a_false_box_in_every_third_frame_is_never_confirmed(self) -> None:
        pipeline = DetectionPipeline(CONFIG)
        for k in range(40):
            boxes = (raw_at(1.5),) if k % 3 == 0 else ()
            assert not any(d.confirmed for d in pipeline.process(frame(k, *boxes), PIN).detections)
        assert pipeline.counters.unconfirmed == 14

    def test_false_boxes_all_over_the_picture_are_never_confirmed(self) -> None:
        pipeline = DetectionPipeline(CONFIG)
        for k, column in enumerate([60.0, 400.0, 210.0, 580.0] * 10):
            boxes = pipeline.process(frame(k, raw(Box(column, 240.0, 20.0, 70.0))), PIN).detections
            assert not any(d.confirmed for d in boxes)


class TestClipped:
    @given(st.floats(0.15, 0.32), st.floats(-0.2, 0.2))
    def test_a_clipped_range_is_never_believed(self, range_m: float, bearing_rad: float) -> None:
        (detection,) = feed(DetectionPipeline(CONFIG), raw_at(range_m, bearing_rad))
        assert detection.clipped
        assert detection.range_sigma_m >= detection.range_m

    @given(st.floats(0.15, 0.32), st.floats(-0.2, 0.2))
    def test_a_clipped_range_is_an_upper_limit_and_the_bearing_stays(
        self, range_m: float, bearing_rad: float
    ) -> None:
        (detection,) = feed(DetectionPipeline(CONFIG), raw_at(range_m, bearing_rad))
        assert detection.range_m >= range_m - 1e-9
        assert detection.bearing_rad == pytest.approx(bearing_rad, abs=0.02)

    @given(st.floats(0.5, 3.0), st.floats(0.0, 0.45), st.sampled_from([-1.0, 1.0]))
    def test_a_box_cut_at_the_side_points_to_the_axis(
        self, range_m: float, hidden: float, side: float
    ) -> None:
        """`hidden` is the share of the width beyond the border; the naive bearing is wrong by half of it."""
        half_width_rad = 0.5 * PIN.width_m / range_m
        edge_rad = CONFIG.camera.half_fov_rad
        bearing_rad = side * (edge_rad - (1.0 - 2.0 * hidden) * half_width_rad)
        (detection,) = feed(DetectionPipeline(CONFIG), raw_at(range_m, bearing_rad))
        assert detection.clipped
        assert detection.bearing_rad == pytest.approx(bearing_rad, abs=0.1 * half_width_rad)

    def test_clipped_boxes_are_counted_beside_the_layers(self) -> None:
        pipeline = DetectionPipeline(CONFIG)
        feed(pipeline, raw_at(0.25), frames=CONFIRM)
        assert pipeline.counters.clipped == CONFIRM
        assert pipeline.counters.confirmed == 1


class TestFrames:
    @pytest.mark.parametrize("stamp_s", [10.0, 9.0, math.nan, math.inf])
    def test_a_frame_that_is_not_newer_is_not_a_second_look(self, stamp_s: float) -> None:
        pipeline = DetectionPipeline(CONFIG)
        pipeline.process(frame(0, raw_at(1.0)), PIN)
        with pytest.raises(StaleInput, match="stamps must grow"):
            pipeline.process(RawDetectionFrame(stamp_s, 1, (raw_at(1.0),)), PIN)
        assert pipeline.counters.frames == 1

    def test_another_target_starts_anew(self) -> None:
        pipeline = DetectionPipeline(CONFIG)
        (pin,) = feed(pipeline, raw_at(1.0), frames=CONFIRM)
        assert pin.confirmed
        bottle = TargetSpec("bottle", 0.25, 0.07)
        (other,) = pipeline.process(frame(CONFIRM, raw_at(1.0, spec=bottle)), bottle).detections
        assert not other.confirmed
        assert other.track_id != pin.track_id

    def test_what_is_out_of_sight_is_not_reported_but_keeps_its_id(self) -> None:
        pipeline = DetectionPipeline(CONFIG)
        (before,) = feed(pipeline, raw_at(1.0), frames=CONFIRM)
        assert feed(pipeline, start=CONFIRM, frames=CONFIG.detector.coast_frames) == ()
        (after,) = feed(pipeline, raw_at(1.0), start=CONFIRM + CONFIG.detector.coast_frames)
        assert after.track_id == before.track_id
        assert after.confirmed


def test_the_same_frames_give_the_same_result() -> None:
    def run() -> list[tuple[Detection, ...]]:
        pipeline = DetectionPipeline(CONFIG)
        return [
            pipeline.process(frame(k, raw_at(1.0 + 0.01 * k, 0.02 * k), raw_at(2.0, -0.3)), PIN).detections
            for k in range(20)
        ]

    assert run() == run()


def test_virtual_time_needs_no_opencv() -> None:
    code = "import sys, target_nav.detectors.pipeline; sys.exit('cv2' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
