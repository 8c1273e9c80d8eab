"""An RPLidar A1 on a serial port: reads scans in the background, starts it again when it was lost.

The reader thread owns the port. A LiDAR that is unplugged, falls silent or stops turning is tried again at growing
intervals until `close`; meanwhile there are no scans, and the nav process stops the wheels because they are old.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import serial

from target_nav.config import LidarConfig
from target_nav.hardware.device_thread import DeviceThread
from target_nav.hardware.rplidar_protocol import DeviceInfo, Health, SampleParser
from target_nav.hardware.rplidar_start import start_lidar, stop_lidar
from target_nav.hardware.rplidar_turns import SAMPLE_PERIOD_S, TurnAssembler
from target_nav.state.types import Scan

READ_BYTES = 250
"""Fifty samples, 25 ms: a thousand small reads a second would cost more than the rest."""

SILENCE_S = 3.0
"""Longer without a scan than spinning up takes: the LiDAR is lost."""


@dataclass(frozen=True)
class LidarStatistics:
    """Counters since the start. `last_scan_s`: when the newest scan was complete, -inf before the first."""

    connected: bool
    connects: int
    scans: int
    dropped_turns: int
    resyncs: int
    skipped_bytes: int
    last_scan_s: float


class RpLidar:
    """One RPLidar A1.

    Args:
        config: port, speed, bins and limits.
        on_scan: called from the reader thread with every scan.
        on_connection: called from the reader thread with True when the LiDAR is back, with False when it was lost,
            and why.
    """

    def __init__(
        self,
        config: LidarConfig,
        on_scan: Callable[[Scan], None],
        on_connection: Callable[[bool, str], None] | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.config = config
        self.info: DeviceInfo | None = None
        self.health: Health | None = None
        self._on_scan = on_scan
        self._clock = clock
        self._serial: serial.Serial | None = None
        self._reader = DeviceThread(
            f"lidar {config.port}",
            self._connect,
            self._read_until_lost,
            self._drop_port,
            on_connection,
            clock,
        )
        self._parser = SampleParser()
        self._turns = TurnAssembler(config)
        self._connects = self._scans = self._resyncs = self._skipped = 0
        self._last_scan_s = float("-inf")

    def open(self, wait_s: float = 0.0) -> None:
        """Open the port, waiting up to `wait_s` for it to appear, start the scan and the reader.

        Raises:
            DeviceError: the port is not there, may not be opened, belongs to another process; nothing answers as an
                RPLidar does, or it reports that it is broken.
        """
        self._reader.open(wait_s)

    def close(self) -> None:
        """Stop scan and motor, end the reader, close the port. May be called again."""
        self._reader.close()

    def raise_failure(self) -> None:
        """Raise what ended the reader thread, if something did: an error in `on_scan` is not swallowed."""
        self._reader.raise_failure()

    @property
    def statistics(self) -> LidarStatistics:
        return LidarStatistics(
            connected=self._serial is not None,
            connects=self._connects,
            scans=self._scans,
            dropped_turns=self._turns.dropped_turns,
            resyncs=self._resyncs + self._parser.resyncs,
            skipped_bytes=self._skipped + self._parser.skipped_bytes,
            last_scan_s=self._last_scan_s,
        )

    def _read_until_lost(self) -> str:
        port = self._serial
        assert port is not None
        began_s = self._clock()
        heard = 0
        try:
            while not self._reader.closing.is_set():
                data = port.read(READ_BYTES)
                now_s = self._clock()
                samples = self._parser.feed(data)
                heard += len(data)
                taken_s = now_s - SAMPLE_PERIOD_S * self._parser.held_samples
                for scan in self._turns.add(samples, taken_s):
                    heard = 0
                    self._scans += 1
                    self._last_scan_s = now_s
                    self._on_scan(scan)
                if now_s - max(began_s, self._last_scan_s) > SILENCE_S:
                    what = (
                        f"{heard} bytes but no whole turn; does its head turn freely?" if heard else "nothing"
                    )
                    return f"for {SILENCE_S:g} s it sent {what}"
        except (serial.SerialException, OSError) as error:
            return str(error)
        return "closed"

    def _connect(self) -> None:
        started = start_lidar(self.config.port, self.config.baud)
        self.info, self.health = started.info, started.health
        self._resyncs += self._parser.resyncs
        self._skipped += self._parser.skipped_bytes
        self._parser = SampleParser()
        self._turns.reset()
        self._serial = started.port
        self._connects += 1

    def _drop_port(self) -> None:
        port, self._serial = self._serial, None
        if port is not None:
            stop_lidar(port)
