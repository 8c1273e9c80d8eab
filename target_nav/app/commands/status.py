"""`target-nav status`: what the robot does now, read from shared memory."""

from __future__ import annotations

import math
import time

import click
from rich.table import Table

from target_nav.app.terminal import table_console
from target_nav.config import Config
from target_nav.ipc import channels

OLD_S = 2.0


@click.command(name="status")
@click.option(
    "--prefix", default=Config().ipc.prefix, show_default=True, help="Of the shared-memory channels."
)
@click.pass_context
def command(ctx: click.Context, prefix: str) -> None:
    """Show state, position and target, and who writes which channel. Exit 1 when no nav process runs."""
    console = table_console()
    table = Table(title=f"channels of prefix {prefix!r}")
    for column in ("channel", "writer", "age", "sequence"):
        table.add_column(column)
    for c in channels.describe(prefix):
        writer = (
            "-" if not c.exists else f"pid {c.writer_pid}" if c.alive else f"gone (was pid {c.writer_pid})"
        )
        age = f"{c.age_s:.2f} s" if math.isfinite(c.age_s) else "-"
        table.add_row(c.name, writer, age, str(c.sequence) if c.exists else "-")
    console.print(table)
    with channels.open_reader(channels.NAV, prefix=prefix) as reader:
        nav = reader.latest()
    if nav is None or time.monotonic() - nav.stamp_s > OLD_S:
        console.print("no nav process runs")
        ctx.exit(1)
    pose, track = nav.pose_in_odom, nav.track
    console.print(f"{nav.state.name}: {nav.running_leaf} {nav.reason}")
    console.print(f"at {pose.x_m:.2f} m, {pose.y_m:.2f} m, {math.degrees(pose.yaw_rad):.0f} deg in odom")
    if track is not None:
        console.print(f"target {track.range_m:.2f} m away, {math.degrees(track.bearing_rad):+.0f} deg")
    console.print(
        f"{nav.rate_hz:.2f} Hz, p99 of lateness {1e3 * nav.jitter_p99_s:.1f} ms, {nav.overruns} overruns"
    )
    if nav.outcome is not None:
        console.print(f"{nav.outcome.kind.value}: {nav.outcome.reason}")
