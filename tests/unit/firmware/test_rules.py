"""The firmware at byte level: what goes in, what comes out, and when it stops by itself."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from target_nav.config import Config
from target_nav.hardware import protocol
from target_nav.sim.host_firmware import HostFirmware
from target_nav.sim.wheels import TICK_M

CONFIG = Config()
LOOP_S = 0.01
STANDING = (0, 0, 0, 0)


class Bench:
    """A firmware with four wheels on a bench: speed follows PWM at once, with motors that differ as motors do."""

    GAINS = (1.0, 0.9, 1.05, 0.85)

    def __init__(self, config: Config = CONFIG) -> None:
        self.firmware = HostFirmware(config)
        self.loops = 0
        self.travel = [0.0] * 4
        self.held = False
        self.lines: list[tuple[float, bytes]] = []

    @property
    def now_s(self) -> float:
        return self.loops * LOOP_S

    def send(self, data: bytes) -> None:
        self.firmware.feed(data, self.now_s)

    def run(self, seconds: float, resend: bytes = b"", every_s: float = 0.05) -> None:
        for i in range(round(seconds / LOOP_S)):
            if resend and i % round(every_s / LOOP_S) == 0:
                self.send(resend)
            self.loops += 1
            for wheel, pwm in enumerate(self.firmware.pwm):
                self.travel[wheel] += 0.0 if self.held else pwm / 255 * 0.6 * self.GAINS[wheel] * LOOP_S
            a, b, c, d = (math.floor(t / TICK_M) for t in self.travel)
            self.firmware.step(self.now_s, (a, b, c, d))
            data = self.firmware.take_output()
            self.lines += [(self.now_s, line + b"\n") for line in data.split(b"\n")[:-1]]
            assert data == b"" or data.endswith(b"\n")

    def of(self, word: bytes) -> list[tuple[float, bytes]]:
        return [(t, line) for t, line in self.lines if line.startswith(word)]


def test_vel_turns_the_wheels_and_odom_says_how_fast():
    bench = Bench()
    bench.run(2.0, resend=b"VEL,200,0,300\n")
    odom = [protocol.parse_line(line) for _, line in bench.of(b"ODOM")]
    vx = [line.vx_mmps for line in odom[10:]]
    wz = [line.wz_mradps for line in odom[10:]]
    assert sum(vx) / len(vx) == pytest.approx(200, abs=3)
    assert sum(wz) / len(wz) == pytest.approx(300, abs=10)
    assert max(abs(line.vy_mmps) for line in odom[10:]) <= 5


def test_odom_comes_20_times_a_second_in_velocity_mode_and_enc_otherwise():
    bench = Bench()
    bench.run(1.0)
    assert [line for _, line in bench.lines] == [b"ENC,0,0,0,0\n"] * 20
    bench.run(1.0, resend=b"VEL,100,0,0\n")
    times = [t for t, _ in bench.of(b"ODOM")]
    assert len(times) == 20
    assert all(later - t == pytest.approx(0.05) for t, later in pairwise(times))
    assert len(bench.of(b"ENC")) == 20


@pytest.mark.parametrize(
    ("command", "signs"),
    [
        (b"VEL,200,0,0\n", (1, 1, 1, 1)),
        (b"VEL,0,200,0\n", (-1, 1, 1, -1)),
        (b"VEL,0,0,500\n", (-1, 1, -1, 1)),
        (b"VEL,-200,0,0\r\n", (-1, -1, -1, -1)),
        (b"VEL,0,0,0\n", (0, 0, 0, 0)),
    ],
)
def test_wheels_turn_by_mecanum_inverse_kinematics(command, signs):
    bench = Bench()
    bench.run(0.5, resend=command)
    assert tuple((p > 0) - (p < 0) for p in bench.firmware.pwm) == signs


def test_without_vel_the_wheels_stop_after_200_ms():
    bench = Bench()
    bench.run(0.5, resend=b"VEL,200,0,0\n", every_s=0.5)  # one VEL at t = 0
    driven = [t for t, line in bench.of(b"ODOM")]
    assert driven[-1] <= 0.2
    assert bench.firmware.pwm == STANDING
    ((stopped_s, line),) = bench.of(b"ERROR")
    assert stopped_s == pytest.approx(0.2, abs=LOOP_S + 1e-9)
    assert line == b"ERROR,WATCHDOG,no VEL for 200 ms, stopped\n"


def test_vel_every_190_ms_keeps_them_turning_and_the_next_vel_starts_them_again():
    bench = Bench()
    bench.run(2.0, resend=b"VEL,200,0,0\n", every_s=0.19)
    assert bench.of(b"ERROR") == []
    bench.run(0.5)
    assert bench.firmware.pwm == STANDING
    bench.run(0.1, resend=b"VEL,200,0,0\n")
    assert min(bench.firmware.pwm) > 0


def test_stop_stops_at_once():
    bench = Bench()
    bench.run(0.5, resend=b"VEL,200,0,0\n")
    bench.send(b"STOP\n")
    assert bench.firmware.pwm == STANDING
    before = list(bench.travel)
    bench.run(0.5)
    assert bench.travel == before
    assert [line for _, line in bench.of(b"ACK")] == [b"ACK,STOP\n"]


def test_half_a_line_waits_for_its_other_half():
    bench = Bench()
    bench.send(b"VEL,20")
    bench.run(0.1)
    assert bench.firmware.pwm == STANDING
    bench.send(b"0,0,0\n")
    bench.run(0.1)
    assert min(bench.firmware.pwm) > 0


@pytest.mark.parametrize(
    "garbage",
    [
        b"VEL\n",
        b"VEL,1,2\n",
        b"VEL,nan,0,0\n",
        b"VEL,1e3,0,0\n",
        b"VEL,99999,0,0\n",
        b"\x00\xff\xfe\n",
        b"GO!\n",
    ],
)
def test_garbage_gets_an_error_and_moves_nothing(garbage):
    bench = Bench()
    bench.send(garbage)
    bench.run(0.1)
    assert bench.firmware.pwm == STANDING
    assert len(bench.of(b"ERROR,BADCMD")) == 1


def test_an_endless_line_is_thrown_away_and_the_next_one_understood():
    bench = Bench()
    for _ in range(50):
        bench.send(b"x" * 1000)
    bench.send(b"\nVEL,200,0,0\n")
    bench.run(0.1)
    assert min(bench.firmware.pwm) > 0
    assert len(bench.of(b"ERROR,OVERFLOW")) == 1


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.one_of(st.binary(max_size=200), st.sampled_from([b"VEL,100,0,0\n", b"STOP\n"])), max_size=8)
)
def test_whatever_comes_in_what_goes_out_are_lines_of_the_protocol(pieces):
    bench = Bench()
    for piece in pieces:
        bench.send(piece)
        bench.run(0.05)
    bench.run(0.5)
    assert all(protocol.parse_line(line) is not None for _, line in bench.lines)
    assert bench.firmware.pwm == STANDING or bench.firmware.mode.value in ("move", "motor")


def test_a_held_wheel_stops_all_after_5_seconds_with_an_error():
    bench = Bench()
    bench.held = True
    bench.run(5.5, resend=b"VEL,200,0,0\n")
    ((t, line), *_) = bench.of(b"ERROR")
    assert t == pytest.approx(5.0, abs=0.05)
    assert line == b"ERROR,STALL,FL does not turn for 5 s, stopped\n"


def test_standing_on_purpose_is_no_stall():
    bench = Bench()
    bench.held = True
    bench.run(8.0, resend=b"VEL,0,0,0\n")
    assert bench.of(b"ERROR") == []


def test_a_speed_under_the_dead_band_does_not_turn_the_motors():
    bench = Bench()
    bench.run(3.0, resend=b"VEL,15,0,0\n")
    assert bench.travel == [0.0] * 4


def test_wheels_that_cannot_keep_up_are_slowed_alike():
    bench = Bench()
    bench.GAINS = (1.0, 1.0, 1.0, 1.0)
    bench.run(2.0, resend=b"VEL,600,300,0\n")
    last = protocol.parse_line(bench.of(b"ODOM")[-1][1])
    # 0.9 m/s of a wheel that makes 0.6: two thirds of what was asked for, in the same direction.
    assert (last.vx_mmps, last.vy_mmps, last.wz_mradps) == pytest.approx((400, 200, 0), abs=6)


def test_a_position_move_ends_at_its_ticks():
    bench = Bench()
    bench.send(b"FWD,100,1719\n")
    bench.run(10.0)
    assert [line for _, line in bench.of(b"ACK")] == [b"ACK,FWD\n"]
    assert sum(bench.travel) / 4 / TICK_M == pytest.approx(1719, abs=30)
    assert bench.firmware.pwm == STANDING
    assert bench.of(b"ODOM") == []


def test_a_position_move_that_takes_over_30_seconds_is_stopped():
    bench = Bench()
    bench.send(b"FWD,50,100000\n")
    bench.run(31.0)
    ((t, line),) = bench.of(b"ERROR")
    assert t == pytest.approx(30.0, abs=0.05)
    assert line.startswith(b"ERROR,TIMEOUT")
    assert bench.firmware.pwm == STANDING


def test_one_motor_can_be_tried_and_counters_be_zeroed():
    bench = Bench()
    bench.send(b"TMOTOR,RL,100\n")
    bench.run(1.0)
    assert bench.firmware.pwm == (0, 0, 100, 0)
    bench.send(b"CALIB\n")
    bench.run(0.1)
    assert bench.of(b"ENC")[-1][1] == b"ENC,0,0,0,0\n"
    assert [line for _, line in bench.of(b"ACK")] == [b"ACK,TMOTOR\n", b"ACK,CALIB\n"]


def test_a_differential_base_refuses_to_strafe():
    bench = Bench(CONFIG.override({"robot.drive": "differential"}))
    bench.send(b"LEFT,100,500\n")
    bench.run(0.5, resend=b"VEL,0,200,0\n")
    assert bench.travel == [0.0] * 4
    assert len(bench.of(b"ERROR,BADCMD,LEFT")) == 1
