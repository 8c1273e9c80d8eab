"""`target-nav calibrate camera`: the lens by a checkerboard, the focal length by a target at known distances."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from datetime import date
from pathlib import Path

import click
import numpy as np
from numpy.typing import NDArray
from rich.table import Table

from target_nav.app.settings import load_config, update_config
from target_nav.app.terminal import table_console
from target_nav.config import Config
from target_nav.detectors.checkerboard import Board, find_corners, fit_lens
from target_nav.detectors.focal_fit import FocalFit, Sighting, fit_focal
from target_nav.errors import ConfigError, DeviceError
from target_nav.ipc import channels
from target_nav.state.types import TargetSpec

IMAGES = (".jpg", ".jpeg", ".png", ".bmp")
LIVE_VIEWS = 20
MOVED_PX = 25.0
"""A view from a camera counts when the board's corners moved so far on average since the last one."""
LIVE_LIMIT_S = 180.0
SIGHTING_LIMIT_S = 15.0

config_option = click.option(
    "--config",
    "config_path",
    type=click.Path(dir_okay=False, path_type=Path),
    default="camera.yaml",
    show_default=True,
    help="Configuration file to read and to write the result into.",
)


@click.group(name="camera")
def command() -> None:
    """The camera: its lens, then its focal length and direction."""


@command.command()
@click.option("--board", default="9x6", show_default=True, metavar="CxR", help="Inner corners of the board.")
@click.option(
    "--square", "square_m", type=float, default=0.025, show_default=True, help="Side of a square, metres."
)
@click.option(
    "--images", type=click.Path(exists=True, file_okay=False, path_type=Path), help="Folder of pictures."
)
@click.option(
    "--source", help="Camera (0, /dev/video0) or video file: views are taken as the board is moved."
)
@config_option
def lens(board: str, square_m: float, images: Path | None, source: str | None, config_path: Path) -> None:
    """Focal lengths, principal point and distortion from views of a checkerboard.

    Hold the board at many places and tilts; it must be seen whole. The stack must not run on the same camera.
    """
    if (images is None) == (source is None):
        raise click.UsageError("give either --images FOLDER or --source CAMERA")
    checkerboard = _board(board, square_m)
    config = _config(config_path)
    camera = config.camera
    views: list[NDArray[np.float32]] = []
    pictures = _folder(images) if images is not None else _camera(str(source), config)
    for name, image in pictures:
        height, width = image.shape[:2]
        if (width, height) != (camera.width_px, camera.height_px):
            raise ConfigError(
                f"{name} is {width}x{height}, the configuration has {camera.width_px}x{camera.height_px}; calibrate "
                "with pictures of the size that is used"
            )
        corners = find_corners(image, checkerboard)
        if images is not None:
            click.echo(f"{name}: {'board found' if corners is not None else 'no whole board'}")
        elif corners is None or (views and abs(corners - views[-1]).mean() < MOVED_PX):
            continue
        else:
            click.echo(f"view {len(views) + 1} of {LIVE_VIEWS}")
        if corners is not None:
            views.append(corners)
        if images is None and len(views) == LIVE_VIEWS:
            break
    fit = fit_lens(views, checkerboard, camera.width_px, camera.height_px)
    keys = fit.keys(camera)
    update_config(config_path, keys, f"checkerboard, {fit.views} views, {date.today()}")
    _show(keys, config)
    click.echo(
        f"{fit.views} views, corners miss by {fit.rms_px:.2f} px, focal length +- {fit.focal_sigma_px:.1f} px; "
        f"written to {config_path}"
    )


@command.command()
@click.option(
    "--at", "distances_m", type=float, multiple=True, required=True,
    help="Distance from the lens to the target's axis, metres; give two to five.",
)  # fmt: skip
@click.option(
    "--height",
    "height_m",
    type=float,
    default=TargetSpec().height_m,
    show_default=True,
    help="Of the target.",
)
@click.option(
    "--class", "class_name", default=TargetSpec().class_name, show_default=True, help="Of the target."
)
@click.option(
    "--boxes", default=40, show_default=True, type=click.IntRange(5, 1000), help="Boxes at each distance."
)
@click.option(
    "--ahead", is_flag=True, help="It stands on the robot's centre line: find the mount's yaw, too."
)
@click.option(
    "--prefix", default=Config().ipc.prefix, show_default=True, help="Of the shared-memory channels."
)
@click.option("--yes", is_flag=True, help="Do not ask before each distance.")
@config_option
def focal(
    distances_m: tuple[float, ...],
    height_m: float,
    class_name: str,
    boxes: int,
    ahead: bool,
    prefix: str,
    yes: bool,
    config_path: Path,
) -> None:
    """Focal length from the target at distances measured with a tape. The detector must be running.

    Only one target may be in the picture. What the detector adds to every box is measured along, so this is worth doing
    after `lens`, too, and again with another detector.
    """
    config = _config(config_path)
    camera = config.camera
    sightings = []
    for distance_m in distances_m:
        if not yes:
            click.prompt(f"Target at {distance_m:g} m; Enter when it stands", "", show_default=False)
        sightings.append(_sighting(prefix, class_name, distance_m, height_m, boxes, config))
        click.echo(f"{distance_m:g} m: {len(sightings[-1].heights_px)} boxes")
    fit = fit_focal(sightings, camera.center_u_px)
    keys = {"camera.focal_px": round(fit.focal_px / camera.pixel_aspect, 2)}
    if ahead:
        keys["camera.yaw_rad"] = round(_yaw(fit, sightings, config), 5)
    update_config(
        config_path, keys, f"target at {', '.join(f'{d:g}' for d in distances_m)} m, {date.today()}"
    )
    _show(keys, config)
    for sighting, residual in zip(sightings, fit.residuals):
        click.echo(f"{sighting.depth_m:g} m: off by {100 * residual:+.1f} %")
    if fit.offset_m is not None:
        click.echo(
            f"the distances look {1000 * fit.offset_m:+.0f} mm longer than given: were they measured from the lens?"
        )
    click.echo(f"focal length {fit.focal_px:.1f} +- {fit.focal_sigma_px:.1f} px; written to {config_path}")


def _yaw(fit: FocalFit, sightings: list[Sighting], config: Config) -> float:
    """The mount's yaw, by which a target on the centre line is seen at `fit.bearing_rad`."""
    depth_m = sorted(s.depth_m for s in sightings)[len(sightings) // 2]
    return math.atan2(-config.camera.y_m, depth_m) - fit.bearing_rad


def _sighting(
    prefix: str, class_name: str, distance_m: float, height_m: float, count: int, config: Config
) -> Sighting:
    """`count` boxes of the target, of frames taken from now on; frames with two of them, or cut off, do not count."""
    border_px, camera = config.detector.border_px, config.camera
    begin_s = time.monotonic()
    heights: list[float] = []
    columns: list[float] = []
    with channels.open_reader(channels.DETECTIONS, prefix=prefix) as reader:
        while len(heights) < count:
            if time.monotonic() - begin_s > SIGHTING_LIMIT_S + 0.5 * count:
                raise DeviceError(
                    f"only {len(heights)} of {count} boxes of a single whole {class_name} at {distance_m:g} m; does "
                    f"the detector run with --prefix {prefix}, and is nothing else of that class to be seen?"
                )
            frame = reader.take_new()
            if frame is None or frame.stamp_s < begin_s:
                time.sleep(0.005)
                continue
            found = [
                box for box in frame.detections
                if box.class_name == class_name and box.score >= config.detector.score_min
            ]  # fmt: skip
            if len(found) != 1:
                continue
            box = found[0]
            top, bottom = box.v_px - 0.5 * box.height_px, box.v_px + 0.5 * box.height_px
            if top > border_px and bottom < camera.height_px - border_px:
                heights.append(box.height_px)
                columns.append(box.u_px)
    return Sighting(distance_m, height_m, tuple(heights), tuple(columns))


def _board(text: str, square_m: float) -> Board:
    columns, _, rows = text.lower().partition("x")
    if not (columns.isdigit() and rows.isdigit() and int(columns) >= 3 and int(rows) >= 3):
        raise click.UsageError(
            f"--board is {text!r}; it must be inner corners such as 9x6, at least 3 each way"
        )
    if not 0.001 <= square_m <= 1.0:
        raise click.UsageError(f"--square is {square_m} m; it must lie in 0.001 ... 1 m")
    return Board(int(columns), int(rows), square_m)


def _config(path: Path) -> Config:
    return load_config(path) if path.exists() else Config()


def _folder(folder: Path) -> Iterator[tuple[str, NDArray[np.uint8]]]:
    import cv2

    paths = sorted(path for path in folder.iterdir() if path.suffix.lower() in IMAGES)
    if not paths:
        raise ConfigError(f"{folder} holds no pictures ({', '.join(IMAGES)})")
    for path in paths:
        image = cv2.imread(str(path), cv2.IMREAD_COLOR)
        if image is None:
            click.echo(f"{path.name}: no picture that OpenCV reads")
            continue
        yield path.name, np.asarray(image, np.uint8)


def _camera(source: str, config: Config) -> Iterator[tuple[str, NDArray[np.uint8]]]:
    from target_nav.detectors.video_source import VideoSource

    camera = config.camera
    video = VideoSource(source, camera.width_px, camera.height_px, camera.rate_hz)
    end_s = time.monotonic() + LIVE_LIMIT_S
    try:
        while not video.ended and time.monotonic() < end_s:
            frame = video.poll()
            if frame is None:
                time.sleep(0.005)
            else:
                yield source, frame.image_bgr
    finally:
        video.close()


def _show(keys: dict[str, float], before: Config) -> None:
    table = Table("key", "before", "now")
    old = {key: value for key, value, _ in before.items()}
    for key, value in keys.items():
        table.add_row(key, f"{old[key]:g}", f"{value:g}")
    table_console().print(table)
