"""The lens from views of a board: a known lens is found again, from its corners and from drawn pictures."""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from target_nav.config import CameraConfig, Config
from target_nav.detectors.checkerboard import Board, Corners, find_corners, fit_lens
from target_nav.errors import DeviceError

BOARD = Board(9, 6, 0.025)
WIDTH, HEIGHT = 640, 480
MATRIX = np.array([[540.0, 0.0, 331.5], [0.0, 545.0, 233.5], [0.0, 0.0, 1.0]])
"""In OpenCV's coordinates: the principal point is half a pixel further in ours."""
LENS = np.array([-0.22, 0.06, 0.0008, -0.0005, 0.0])


def poses(
    count: int, tilt_rad: float, seed: int = 0
) -> list[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Rotation and translation of boards that lie all over the picture."""
    rng = np.random.default_rng(seed)
    found = []
    while len(found) < count:
        rotation = np.append(rng.uniform(-tilt_rad, tilt_rad, 2), rng.uniform(-0.2, 0.2))
        depth = rng.uniform(0.35, 0.7)
        where = rng.uniform(-1.0, 1.0, 2) * (0.30 * depth, 0.22 * depth)
        translation = np.append(where - BOARD.points()[:, :2].mean(axis=0), depth)
        corners = project(rotation, translation)
        if corners.min() > 12 and (corners.max(axis=0) < (WIDTH - 12, HEIGHT - 12)).all():
            found.append((rotation, translation))
    return found


def project(rotation: NDArray[np.float64], translation: NDArray[np.float64]) -> Corners:
    points, _ = cv2.projectPoints(BOARD.points(), rotation, translation, MATRIX, LENS)
    return np.asarray(points, np.float32).reshape(-1, 2)


SCALE = 2


@lru_cache(maxsize=1)
def all_rays() -> NDArray[np.float64]:
    v, u = np.mgrid[0 : SCALE * HEIGHT, 0 : SCALE * WIDTH]
    pixels = (np.stack([u, v], axis=-1).reshape(-1, 1, 2) + 0.5) / SCALE - 0.5
    return np.asarray(cv2.undistortPoints(pixels.astype(np.float64), MATRIX, LENS)).reshape(-1, 2)


def drawn(rotation: NDArray[np.float64], translation: NDArray[np.float64]) -> NDArray[np.uint8]:
    """The picture of a board, by four rays a pixel through the lens."""
    scale, rays = SCALE, all_rays()
    turn, _ = cv2.Rodrigues(rotation)
    to_board = np.linalg.inv(np.column_stack([turn[:, 0], turn[:, 1], translation]))
    on_board = np.column_stack([rays, np.ones(len(rays))]) @ to_board.T
    cell = np.floor(on_board[:, :2] / on_board[:, 2:] / BOARD.square_m).astype(int)
    inside = (cell >= -1).all(axis=1) & (cell[:, 0] < BOARD.columns) & (cell[:, 1] < BOARD.rows)
    grey = np.where(inside & (cell.sum(axis=1) % 2 == 0), 30, 220).astype(np.uint8)
    large = grey.reshape(scale * HEIGHT, scale * WIDTH)
    return cv2.cvtColor(cv2.resize(large, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA), cv2.COLOR_GRAY2BGR)


def test_a_known_lens_is_found_again() -> None:
    rng = np.random.default_rng(1)
    views = [(project(*pose) + rng.normal(0.0, 0.1, (54, 2))).astype(np.float32) for pose in poses(20, 0.6)]
    fit = fit_lens(views, BOARD, WIDTH, HEIGHT)
    assert fit.focal_x_px == pytest.approx(540.0, abs=4 * fit.focal_sigma_px)
    assert fit.focal_y_px / fit.focal_x_px == pytest.approx(545.0 / 540.0, abs=0.002)
    assert (fit.center_u_px, fit.center_v_px) == pytest.approx((332.0, 234.0), abs=2.0)
    assert fit.lens[0] == pytest.approx(-0.22, abs=0.02)
    assert fit.rms_px == pytest.approx(0.14, abs=0.05)
    assert 0.0 < fit.focal_sigma_px < 3.0


def test_its_keys_are_those_of_the_configuration_and_give_the_lens_back() -> None:
    fit = fit_lens([project(*pose) for pose in poses(12, 0.6)], BOARD, WIDTH, HEIGHT)
    camera = Config().override(fit.keys(CameraConfig())).camera
    assert (camera.focal_px, camera.focal_y_px) == pytest.approx((540.0, 545.0), abs=0.3)
    assert (camera.center_u_px, camera.center_v_px) == pytest.approx((332.0, 234.0), abs=0.3)
    assert camera.lens == pytest.approx(tuple(LENS), abs=0.003)


def test_corners_are_found_to_a_fraction_of_a_pixel() -> None:
    for pose in poses(2, 0.5, seed=4):
        found = find_corners(drawn(*pose), BOARD)
        assert found is not None
        error = np.linalg.norm(found - project(*pose), axis=1)
        other = np.linalg.norm(found[::-1] - project(*pose), axis=1)  # The board read from its other end.
        assert min(error.max(), other.max()) < 0.3


def test_a_picture_without_a_whole_board_has_no_corners() -> None:
    assert find_corners(np.full((HEIGHT, WIDTH, 3), 127, np.uint8), BOARD) is None
    half = drawn(*poses(1, 0.3)[0]).copy()
    half[:, :330] = 127
    assert find_corners(half, BOARD) is None


def test_few_views_are_not_enough() -> None:
    with pytest.raises(DeviceError, match="whole in 3 views"):
        fit_lens([project(*pose) for pose in poses(3, 0.5)], BOARD, WIDTH, HEIGHT)


def test_views_that_leave_the_picture_s_edges_unseen_are_not_enough() -> None:
    middle = [(r, np.array([-0.1, -0.06, 1.2])) for r, _ in poses(10, 0.5)]
    with pytest.raises(DeviceError, match="into the corners"):
        fit_lens([project(*pose) for pose in middle], BOARD, WIDTH, HEIGHT)


def test_views_that_face_the_camera_are_refused() -> None:
    rng = np.random.default_rng(2)
    views = [
        (project(np.array([0.0, 0.0, r[2]]), t) + rng.normal(0.0, 0.3, (54, 2))).astype(np.float32)
        for r, t in poses(10, 0.01)
    ]
    with pytest.raises(DeviceError, match="tilt the board"):
        fit_lens(views, BOARD, WIDTH, HEIGHT)


def test_a_board_that_does_not_fit_is_told() -> None:
    rng = np.random.default_rng(3)
    views = [(project(*pose) + rng.normal(0.0, 3.0, (54, 2))).astype(np.float32) for pose in poses(12, 0.5)]
    with pytest.raises(DeviceError, match="is the board flat"):
        fit_lens(views, BOARD, WIDTH, HEIGHT)
