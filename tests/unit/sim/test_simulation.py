"""The whole simulator: the same seed gives the same bytes, and components do not disturb each other."""

import math
from dataclasses import replace

import numpy as np
import pytest

from target_nav.hardware import protocol
from target_nav.nav.odometry import OdometryIntegrator
from target_nav.sim.arena import Arena, load_arena
from target_nav.sim.simulation import Simulation
from target_nav.sim.streams import stream
from target_nav.state.types import Odometry, RawDetectionFrame, Scan, Twist2D

ARENA = load_arena("decoys")


class Log:
    """Everything a robot would notice, and the truth."""

    def __init__(self) -> None:
        self.serial = b""
        self.scans: list[Scan] = []
        self.boxes: list[RawDetectionFrame] = []

    def fingerprint(self) -> tuple[object, ...]:
        return (
            self.serial,
            tuple((scan.stamp_s, scan.ranges_m.tobytes()) for scan in self.scans),
            tuple(self.boxes),
        )


def command(now_s: float) -> bytes:
    return protocol.encode_velocity(Twist2D(0.12, 0.06 * math.sin(now_s), 0.4 * math.cos(0.7 * now_s)))


def run(
    arena: Arena = ARENA, seed: int = 7, seconds: float = 6.0, poll_s: float = 0.05, start_s: float = 0.0
) -> tuple[Simulation, Log]:
    simulation, log = Simulation(arena, seed, start_s), Log()
    for tick in range(round(seconds / 0.05)):
        simulation.serial_write(command(tick * 0.05))
        for poll in range(round(0.05 / poll_s)):
            simulation.step_to(start_s + tick * 0.05 + (poll + 1) * poll_s)
            log.serial += simulation.serial_read()
            log.scans += simulation.take_scans()
            log.boxes += simulation.take_boxes()
    return simulation, log


def test_the_same_seed_gives_the_same_bytes_and_another_seed_others():
    (first, log), (second, again) = run(), run()
    assert log.fingerprint() == again.fingerprint()
    assert first.path == second.path
    other, other_log = run(seed=8)
    assert other_log.fingerprint() != log.fingerprint()
    assert other.path != first.path


def test_how_often_somebody_asks_does_not_matter():
    (coarse, log), (fine, again) = run(), run(poll_s=0.01)
    assert log.fingerprint() == again.fingerprint()
    assert coarse.path == fine.path


def test_irregular_calls_in_real_time_come_to_the_same():
    even, odd = Simulation(ARENA, 3, 1000.0), Simulation(ARENA, 3, 1000.0)
    rng, now_s = np.random.default_rng(1), 1000.0
    even.step_to(1004.0)
    while now_s < 1004.0:
        now_s = min(now_s + float(rng.exponential(0.013)), 1004.0)
        odd.step_to(now_s)
        odd.step_to(now_s - 0.5)  # a time that has passed changes nothing
        assert 0.0 <= now_s - odd.now_s < 0.01 + 1e-6
    assert even.serial_read() == odd.serial_read()
    assert [s.ranges_m.tobytes() for s in even.take_scans()] == [
        s.ranges_m.tobytes() for s in odd.take_scans()
    ]


def test_stamps_are_on_the_caller_s_axis():
    _, log = run(start_s=5000.0, seconds=2.0)
    stamps = [scan.stamp_s for scan in log.scans] + [frame.stamp_s for frame in log.boxes]
    assert stamps
    assert all(5000.0 <= stamp <= 5002.0 for stamp in stamps)


@pytest.mark.parametrize(
    ("change", "unchanged"),
    [
        ({"lidar.noise_scale": 3.0, "lidar.beams": 180}, ("serial", "boxes")),
        ({"camera.miss_probability": 0.5, "camera.false_rate": 0.3}, ("serial", "scans")),
        ({"drive_sim.slip_heading_rad": 0.3, "drive_sim.slip_rate_per_m": 5.0}, ("serial",)),
    ],
)
def test_a_change_in_one_component_does_not_shift_another_s_randomness(change, unchanged):
    changed = replace(ARENA, config=ARENA.config.override(change))
    (_, log), (_, other) = run(), run(changed)
    parts = {name: i for i, name in enumerate(("serial", "scans", "boxes"))}
    for name in unchanged:
        assert log.fingerprint()[parts[name]] == other.fingerprint()[parts[name]]
    assert log.fingerprint() != other.fingerprint()


def test_odometry_is_near_the_truth_and_not_the_truth():
    simulation, log = run(seconds=20.0)
    odometry, lines, pose = OdometryIntegrator(), protocol.LineAssembler(), None
    for i, line in enumerate(lines.feed(log.serial)):
        message = protocol.parse_line(line)
        assert isinstance(message, protocol.OdomLine)
        pose = odometry.add((i + 1) * 0.05, message.to_twist())
    assert isinstance(pose, Odometry)
    start, true, believed = ARENA.robot, simulation.true_pose, pose.pose_in_odom
    error_m = math.hypot(true.x_m - start.x_m - believed.x_m, true.y_m - start.y_m - believed.y_m)
    assert 0.005 < error_m < 0.1 * simulation.drive.path_m + 0.02


def test_late_odometry_is_the_same_odometry_later():
    late = replace(ARENA, config=ARENA.config.override({"drive_sim.time_offset_s": 0.2}))
    (_, log), (_, delayed) = run(), run(late)
    assert len(delayed.serial) < len(log.serial)
    assert log.serial.startswith(delayed.serial)


def test_the_robot_stops_200_ms_after_the_last_command():
    simulation = Simulation(load_arena("open_floor"), 1)
    for tick in range(40):
        simulation.serial_write(b"VEL,200,0,0\n")
        simulation.step_to((tick + 1) * 0.05)
    assert simulation.true_twist.vx_mps > 0.15
    # 50 ms of the 200 have passed since the last VEL; then the wheels run out with their lag.
    simulation.step_to(2.0 + 0.14)
    assert simulation.true_twist.vx_mps > 0.15
    simulation.step_to(2.0 + 0.15 + 0.4)
    assert simulation.true_twist.vx_mps < 0.01
    simulation.step_to(4.0)
    assert simulation.judge(0.1, reported_arrived=False).standing_still


def test_a_wheel_that_is_held_makes_the_firmware_stop_and_say_so():
    simulation = Simulation(load_arena("open_floor"), 1)
    simulation.drive.jammed.add(2)
    said = b""
    for tick in range(110):
        simulation.serial_write(b"VEL,30,0,0\n")
        simulation.step_to((tick + 1) * 0.05)
        said += simulation.serial_read()
    assert b"ERROR,STALL,RL does not turn for 5 s, stopped\n" in said


def test_the_path_is_the_truth_at_20_hz():
    simulation, _ = run(seconds=3.0)
    times = [point[0] for point in simulation.path]
    assert np.allclose(np.diff(times), 0.05)
    assert simulation.path[0] == [0.0, ARENA.robot.x_m, ARENA.robot.y_m, ARENA.robot.yaw_rad]
    last = simulation.true_pose
    assert simulation.path[-1][1:] == [last.x_m, last.y_m, last.yaw_rad]
    assert simulation.pose_at(times[-1]).x_m == pytest.approx(last.x_m)
    middle = simulation.pose_at(2.0)
    assert [middle.x_m, middle.y_m] == pytest.approx(simulation.path[40][1:3])


def test_driving_into_the_pin_is_a_collision_at_no_distance():
    simulation = Simulation(load_arena("open_floor"), 1)
    assert simulation.target_distance_m is not None
    before = simulation.target_distance_m
    for tick in range(400):
        pose, target = simulation.true_pose, simulation.arena.target
        bearing = math.atan2(target.y_m - pose.y_m, target.x_m - pose.x_m) - pose.yaw_rad
        simulation.serial_write(protocol.encode_velocity(Twist2D(0.25, 0.0, 1.5 * bearing)))
        simulation.step_to((tick + 1) * 0.05)
    verdict = simulation.judge(stand_off_m=0.1, reported_arrived=True)
    assert verdict.collided
    assert not verdict.success
    assert verdict.min_clearance_m == 0.0
    assert simulation.target_distance_m == pytest.approx(0.0, abs=0.006)
    assert verdict.stop_error_m == pytest.approx(-0.1, abs=0.006)
    assert verdict.path_m == pytest.approx(before, rel=0.1)


def test_nobody_takes_anything_and_memory_stays_bounded():
    simulation = Simulation(load_arena("no_pin"), 1)
    simulation.step_to(40.0)
    assert len(simulation.take_scans()) <= 64
    assert len(simulation.take_boxes()) <= 256
    assert simulation.target_distance_m is None


def test_each_component_has_its_own_stream_of_the_seed():
    draws = {name: tuple(stream(5, name).random(4)) for name in ("drive", "lidar", "camera")}
    assert len(set(draws.values())) == 3
    assert draws["lidar"] == tuple(stream(5, "lidar").random(4))
    assert draws["lidar"] != tuple(stream(6, "lidar").random(4))


def test_a_negative_seed_is_refused():
    with pytest.raises(ValueError, match="seed is -1; it must be 0 or more"):
        Simulation(ARENA, -1)
