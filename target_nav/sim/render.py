"""What the robot's camera sees: a pinhole picture of an arena, drawn with NumPy and OpenCV alone.

Floor by homography; walls, boxes and cylinders by one ray per column; pins and bottles by one ray per pixel; then the
sensor: a little blur, exposure and noise. About 7 ms a frame on one core of a desk machine.
"""

from __future__ import annotations

import math

import cv2
import numpy as np

from target_nav.config import Config
from target_nav.errors import ConfigError
from target_nav.sim.arena import Arena, BoxObstacle, CircleObstacle, PlacedObject, WallObstacle
from target_nav.sim.geometry import box_corners
from target_nav.sim.objects import OBSTACLE_HEIGHT_M, Rgb
from target_nav.sim.render_canvas import Canvas, ImageBgr, View
from target_nav.sim.render_floor import Floor
from target_nav.sim.render_look import Bgr, Look
from target_nav.sim.render_revolved import Revolved, body_of, paint_revolved, paint_shadow
from target_nav.sim.render_surfaces import Cylinder, Facet, FacetSet, paint_cylinder
from target_nav.sim.render_truth import TrueBox, true_box
from target_nav.state.types import Pose2D
from target_nav.utils.frames import compose

WALL_HEIGHT_M = 2.4
OBSTACLE_COLOURS: tuple[Bgr, ...] = (
    (112.0, 152.0, 184.0),  # cardboard
    (214.0, 218.0, 218.0),  # a white box: colour alone must not make a pin
    (150.0, 104.0, 66.0),  # blue
    (58.0, 62.0, 148.0),  # brick red
    (84.0, 84.0, 82.0),  # dark grey
)
INNER_WALL_BGR: Bgr = (186.0, 192.0, 190.0)
OBSTACLE_THINGS_PER_M = 0.6
"""Labels and prints on boxes."""
BROWN_GLASS_RGB: Rgb = (98, 58, 34)

NOISE_MARGIN_PX = 64
EXPOSURE_DRIFT = 0.02
EXPOSURE_PERIOD_S = 7.0
EXPOSURE_NOISE = 0.004


class Renderer:
    """Draws one arena. The noise of the sensor is drawn once and shifted at random from frame to frame."""

    def __init__(
        self, arena: Arena, config: Config, mount_error_rad: float = 0.0, look: Look | None = None
    ) -> None:
        """`mount_error_rad` is how far the camera is turned to the left of where `config` says it is.

        `look` is how the room is painted and furnished; default: the plain one.

        Raises:
            ConfigError: the camera is so high that it would look on top of the obstacles, which have none here.
        """
        cv2.setNumThreads(1)
        camera = config.camera
        if camera.z_m >= OBSTACLE_HEIGHT_M:
            raise ConfigError(
                f"camera.z_m is {camera.z_m:g} m; the rendered camera must stay under the obstacles' height of "
                f"{OBSTACLE_HEIGHT_M:g} m (lower it, or run the mission in virtual time)"
            )
        self._camera_in_base = Pose2D(camera.x_m, camera.y_m, camera.yaw_rad + mount_error_rad)
        self._canvas, self._scratch = Canvas(camera), Canvas(camera)
        self._look = look = look or Look()
        self._floor = Floor(arena.bounds, look)
        self._facet_sets = [FacetSet(_bounding_walls(arena, look), look.wall_things, look.seed)]
        standing = _standing_facets(arena)
        if standing:
            self._facet_sets.append(FacetSet(standing, OBSTACLE_THINGS_PER_M, look.seed + 1))
        self._cylinders = [
            Cylinder(o.x_m, o.y_m, o.radius_m, OBSTACLE_HEIGHT_M, OBSTACLE_COLOURS[i % len(OBSTACLE_COLOURS)])
            for i, o in enumerate(arena.obstacles)
            if isinstance(o, CircleObstacle)
        ]
        self._things = [(thing, _body(i, thing)) for i, thing in enumerate(arena.objects)]
        shape = (camera.height_px + NOISE_MARGIN_PX, camera.width_px + NOISE_MARGIN_PX, 3)
        noise = np.random.default_rng(0).normal(0.0, look.noise_sigma * camera.noise_scale, shape)
        self._noise = np.rint(noise).astype(np.int16)

    def draw(self, true_pose: Pose2D, stamp_s: float, rng: np.random.Generator) -> ImageBgr:
        """The picture from base_link at `true_pose` (world), uint8 BGR of shape (height, width, 3), a new array.

        `stamp_s` moves the slow drift of the exposure; `rng` gives the noise.
        """
        view = self._canvas.view_from(compose(true_pose, self._camera_in_base))
        self._draw_scene(view)
        return self._expose(stamp_s, rng)

    def true_boxes(self, true_pose: Pose2D) -> tuple[TrueBox, ...]:
        """Where the things are in a picture from `true_pose`, those wholly hidden or outside left out."""
        view = self._canvas.view_from(compose(true_pose, self._camera_in_base))
        self._draw_scene(view)
        boxes = (
            true_box(thing.class_name, body, thing.x_m, thing.y_m, view, self._canvas, self._scratch)
            for thing, body in self._things
        )
        return tuple(box for box in boxes if box is not None and box.visible > 0.0)

    def _draw_scene(self, view: View) -> None:
        canvas = self._canvas
        canvas.depth_m.fill(np.inf)
        canvas.image_bgr[: math.ceil(view.center_v_px)] = self._look.ceiling_bgr
        self._floor.draw(view, canvas.image_bgr)
        for cylinder in self._cylinders:
            paint_shadow(cylinder.radius_m, cylinder.x_m, cylinder.y_m, view, canvas)
        for thing, body in self._things:
            paint_shadow(body.max_radius_m, thing.x_m, thing.y_m, view, canvas)
        for facets in self._facet_sets:
            facets.paint(view, canvas)
        for cylinder in self._cylinders:
            paint_cylinder(cylinder, view, canvas)
        for thing, body in sorted(self._things, key=lambda pair: -_distance(view, pair[0])):
            paint_revolved(body, thing.x_m, thing.y_m, view, canvas)

    def _expose(self, stamp_s: float, rng: np.random.Generator) -> ImageBgr:
        drift = EXPOSURE_DRIFT * math.sin(2.0 * math.pi * stamp_s / EXPOSURE_PERIOD_S)
        gain = 1.0 + drift + EXPOSURE_NOISE * float(rng.standard_normal())
        picture: ImageBgr = np.asarray(
            cv2.GaussianBlur(self._canvas.image_bgr, (3, 3), self._look.blur_sigma_px), np.uint8
        )
        row, column = (int(shift) for shift in rng.integers(0, NOISE_MARGIN_PX + 1, 2))
        rows, columns = picture.shape[:2]
        noise = self._noise[row : row + rows, column : column + columns]
        picture = _balance(picture, gain * self._look.gain, self._look.tint_bgr)
        return np.asarray(cv2.add(picture, noise, dtype=cv2.CV_8U), np.uint8)


def _balance(picture: ImageBgr, gain: float, tint_bgr: Bgr) -> ImageBgr:
    if tint_bgr == (1.0, 1.0, 1.0):
        return np.asarray(cv2.convertScaleAbs(picture, alpha=gain), np.uint8)
    levels = np.arange(256, dtype=np.float32)[:, None] * (gain * np.array(tint_bgr, np.float32))
    return np.asarray(cv2.LUT(picture, np.clip(levels, 0.0, 255.0).astype(np.uint8)[None]), np.uint8)


def _bounding_walls(arena: Arena, look: Look) -> list[Facet]:
    x0, y0, x1, y1 = arena.bounds
    corners = ((x0, y0), (x1, y0), (x1, y1), (x0, y1))
    return [
        Facet(*corners[i], *corners[(i + 1) % 4], WALL_HEIGHT_M, look.walls_bgr[i], skirting=True)
        for i in range(4)
    ]


def _standing_facets(arena: Arena) -> list[Facet]:
    facets: list[Facet] = []
    for index, obstacle in enumerate(arena.obstacles):
        if isinstance(obstacle, WallObstacle):
            ends = (obstacle.x1_m, obstacle.y1_m, obstacle.x2_m, obstacle.y2_m)
            facets.append(Facet(*ends, OBSTACLE_HEIGHT_M, INNER_WALL_BGR, skirting=True))
        elif isinstance(obstacle, BoxObstacle):
            colour = OBSTACLE_COLOURS[index % len(OBSTACLE_COLOURS)]
            corners = box_corners(
                obstacle.x_m, obstacle.y_m, obstacle.length_m, obstacle.width_m, obstacle.yaw_rad
            )
            for i, corner in enumerate(corners):
                facets.append(Facet(*corner, *corners[(i + 1) % 4], OBSTACLE_HEIGHT_M, colour))
    return facets


def _body(index: int, thing: PlacedObject) -> Revolved:
    """Every other bottle is brown."""
    shape = thing.shape
    body_rgb = BROWN_GLASS_RGB if thing.class_name == "bottle" and index % 2 == 0 else shape.body_rgb
    band = _bgr(shape.band_rgb) if shape.band_rgb is not None else None
    return body_of(thing.class_name, shape.height_m, shape.radius_m, _bgr(body_rgb), band)


def _bgr(rgb: Rgb) -> Bgr:
    red, green, blue = rgb
    return float(blue), float(green), float(red)


def _distance(view: View, thing: PlacedObject) -> float:
    return math.hypot(thing.x_m - view.camera_in_world.x_m, thing.y_m - view.camera_in_world.y_m)
