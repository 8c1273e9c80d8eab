"""The lens from pictures of a checkerboard: focal lengths, principal point, distortion.

Zhang, "A flexible new technique for camera calibration", PAMI 22(11), 2000, as OpenCV does it. What makes a calibration
worthless is told instead of written down: too few views, all alike, or corners that do not fit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from target_nav.config import CameraConfig
from target_nav.detectors.detector import ImageBgr
from target_nav.errors import DeviceError

Corners = NDArray[np.float32]
"""Inner corners of one view, shape (columns * rows, 2), as OpenCV counts: 0 is the middle of the first pixel."""

VIEWS_MIN = 8
RMS_MAX_PX = 1.0
COVER_MIN = 0.5
"""Of width and height: where no corner ever was, distortion is a guess."""
FOCAL_SIGMA_MAX = 0.02
"""Relative."""
TILT_MIN_RAD, TILTED_SHARE_MIN = 0.25, 0.4
"""Boards that face the camera cannot tell focal length from distance, and the fit does not know it: ten such views gave
304 px with a sigma of 0.3 where 540 was right. So that many must be tilted."""


@dataclass(frozen=True)
class Board:
    """A checkerboard by its inner corners (a board of 10 x 7 squares has 9 x 6) and the side of a square."""

    columns: int
    rows: int
    square_m: float

    def points(self) -> NDArray[np.float32]:
        """Corners on the board, metres, shape (columns * rows, 3)."""
        grid = np.zeros((self.columns * self.rows, 3), np.float32)
        grid[:, :2] = self.square_m * np.mgrid[0 : self.columns, 0 : self.rows].T.reshape(-1, 2)
        return grid


@dataclass(frozen=True)
class LensFit:
    """In picture coordinates of this project (0 is the edge of the first pixel); `lens` is k1 k2 p1 p2 k3."""

    focal_x_px: float
    focal_y_px: float
    center_u_px: float
    center_v_px: float
    lens: tuple[float, float, float, float, float]
    rms_px: float
    focal_sigma_px: float
    views: int

    def keys(self, camera: CameraConfig) -> dict[str, float]:
        """As keys of the configuration."""
        k1, k2, p1, p2, k3 = self.lens
        return {
            "camera.focal_px": round(self.focal_x_px, 2),
            "camera.pixel_aspect": round(self.focal_y_px / self.focal_x_px, 5),
            "camera.center_right_px": round(self.center_u_px - 0.5 * camera.width_px, 2),
            "camera.center_down_px": round(self.center_v_px - 0.5 * camera.height_px, 2),
            "camera.lens_k1": round(k1, 6),
            "camera.lens_k2": round(k2, 6),
            "camera.lens_p1": round(p1, 6),
            "camera.lens_p2": round(p2, 6),
            "camera.lens_k3": round(k3, 6),
        }


def find_corners(image_bgr: ImageBgr, board: Board) -> Corners | None:
    """The board's inner corners to a fraction of a pixel, None if it is not wholly seen."""
    grey = cv2.cvtColor(image_bgr, cv2.COLOR_BGR2GRAY)
    found, corners = cv2.findChessboardCorners(
        grey, (board.columns, board.rows), flags=cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_NORMALIZE_IMAGE
    )
    if not found:
        return None
    # A window of half the least distance of two corners, so that it never holds another one.
    flat = corners.reshape(-1, 2)
    spacing = float(
        np.min(np.linalg.norm(np.diff(flat.reshape(board.rows, board.columns, 2), axis=1), axis=2))
    )
    half = int(np.clip(0.5 * spacing - 1.0, 2, 11))
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 40, 1e-3)
    fine = cv2.cornerSubPix(grey, corners.reshape(-1, 1, 2), (half, half), (-1, -1), criteria)
    return np.asarray(fine, np.float32).reshape(-1, 2)


def fit_lens(views: Sequence[Corners], board: Board, width_px: int, height_px: int) -> LensFit:
    """Intrinsics and distortion from the corners of at least `VIEWS_MIN` views.

    The third radial term is left at zero: the views of a small board do not tell it from the second.

    Raises:
        DeviceError: too few views, views that leave much of the picture unseen or are all alike, or corners that do not
            fit; with what to do about it.
    """
    if len(views) < VIEWS_MIN:
        raise DeviceError(
            f"the board is whole in {len(views)} views (at least {VIEWS_MIN}); take more, and check --board: it "
            f"counts inner corners, here {board.columns} x {board.rows}"
        )
    corners = np.concatenate(views)
    cover = np.ptp(corners, axis=0) / (width_px, height_px)
    if float(cover.min()) < COVER_MIN:
        raise DeviceError(
            f"the views reach over {100 * cover[0]:.0f} % of the picture's width and {100 * cover[1]:.0f} % of its "
            f"height (at least {100 * COVER_MIN:g} %); move the board into the corners as well"
        )
    objects = [board.points()] * len(views)
    points = [view.reshape(-1, 1, 2) for view in views]
    unknown, none = np.zeros((3, 3)), np.zeros(5)
    rms, matrix, distortion, turns, _, sigma, _, _ = cv2.calibrateCameraExtended(
        objects, points, (width_px, height_px), unknown, none, flags=cv2.CALIB_FIX_K3
    )
    if not np.isfinite(rms) or rms > RMS_MAX_PX:
        raise DeviceError(
            f"corners miss the model by {rms:.2f} px (limit {RMS_MAX_PX:g} px); is the board flat, is it sharp?"
        )
    tilts_rad = [float(np.arccos(np.clip(cv2.Rodrigues(turn)[0][2, 2], -1.0, 1.0))) for turn in turns]
    tilted = sum(tilt_rad > TILT_MIN_RAD for tilt_rad in tilts_rad)
    if tilted < TILTED_SHARE_MIN * len(views):
        raise DeviceError(
            f"the board is tilted by 15 degrees or more in {tilted} of {len(views)} views (at least "
            f"{100 * TILTED_SHARE_MIN:g} %); tilt the board each way: views that face the camera cannot tell focal "
            "length from distance"
        )
    focal_sigma_px = float(np.asarray(sigma).ravel()[0])
    focal_px = float(matrix[0, 0])
    if focal_sigma_px > FOCAL_SIGMA_MAX * focal_px:
        raise DeviceError(
            f"the focal length is {focal_px:.0f} +- {focal_sigma_px:.0f} px (limit {100 * FOCAL_SIGMA_MAX:g} %); take "
            "more views, nearer and tilted by 20 to 40 degrees"
        )
    k1, k2, p1, p2, k3 = (float(k) for k in np.asarray(distortion).ravel()[:5])
    return LensFit(
        focal_px,
        float(matrix[1, 1]),
        float(matrix[0, 2]) + 0.5,
        float(matrix[1, 2]) + 0.5,
        (k1, k2, p1, p2, k3),
        float(rms),
        focal_sigma_px,
        len(views),
    )
