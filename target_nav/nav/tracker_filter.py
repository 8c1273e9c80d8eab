"""One target's position by Kalman filter, together with the camera's two constant errors.

The state is (x, y, s, b): the target in odom, the relative error of the camera's ranges, the error of its bearings.
A focal length that is 4 % off does not average out over a hundred frames. With s and b in the state the position stays
as uncertain as it is, the gates stay as wide as they must be, and one LiDAR fix settles position and camera at once.

Extended Kalman filter on the camera's own range and bearing:
    range = |p - c| (1 + s) + noise        bearing = atan2(p - c) - yaw + b + noise
with c and yaw the camera's pose in odom when the frame was exposed. The update is filterpy's, in Joseph form. As the
target stands still, measurements may come late and in any order.
"""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass

import numpy as np
from filterpy.kalman import KalmanFilter

from target_nav.config import TrackConfig
from target_nav.nav.facing import FaceLook
from target_nav.state.types import FloatArray, Pose2D
from target_nav.utils.frames import wrap_angle

NEAREST_M = 0.05
"""Bearings of a target nearer to the camera than this mean nothing."""
OWN_MOTION_S = 0.5
"""A target pushed with `process_noise_mps2` for so long, again and again: its own motion as a random walk."""
MIN_VARIANCES = np.array([0.003**2, 0.003**2, 1e-6, 1e-6])
"""Nobody knows a position better than 3 mm, a scale better than 0.1 %, a mount better than 1 mrad: however many exact
measurements come, the covariance stays positive."""


@dataclass(frozen=True)
class CameraMeasurement:
    """One detection as the filter takes it. `range_m` of a clipped box is an upper bound and nothing else."""

    range_m: float
    range_sigma_m: float
    bearing_rad: float
    bearing_sigma_rad: float
    bearing_only: bool
    confirmed: bool = True
    looks: tuple[FaceLook, ...] = ()
    """Where its face may look, if the target is flat."""


@dataclass(frozen=True, eq=False)
class CameraExpectation:
    """What the camera should measure of a target, with the covariance that comes from the state alone."""

    range_m: float
    bearing_rad: float
    jacobian: FloatArray
    range_variance: float
    bearing_variance: float
    covariance: float

    def distance(self, measurement: CameraMeasurement) -> tuple[float, float]:
        """Squared Mahalanobis distance of a measurement, and -2 log of its likelihood up to a constant."""
        off_rad = wrap_angle(measurement.bearing_rad - self.bearing_rad)
        s_bb = self.bearing_variance + measurement.bearing_sigma_rad**2
        if measurement.bearing_only:
            squared = off_rad * off_rad / s_bb
            return squared, squared + math.log(s_bb)
        off_m = measurement.range_m - self.range_m
        s_rr = self.range_variance + measurement.range_sigma_m**2
        determinant = s_rr * s_bb - self.covariance**2
        squared = (
            off_m * off_m * s_bb - 2.0 * off_m * off_rad * self.covariance + off_rad * off_rad * s_rr
        ) / determinant
        return squared, squared + math.log(determinant)


def _kalman_filter() -> KalmanFilter:
    kalman = KalmanFilter(dim_x=4, dim_z=2)
    kalman.inv = _inverse
    return kalman


def _inverse(matrix: FloatArray) -> FloatArray:
    """Of (1, 1) or (2, 2), in a quarter of the general routine's time."""
    if len(matrix) == 1:
        return 1.0 / matrix
    (a, b), (c, d) = matrix.tolist()
    determinant = a * d - b * c
    return np.array([[d / determinant, -b / determinant], [-c / determinant, a / determinant]])


class TargetFilter:
    """Where one target is believed to be, in odom."""

    def __init__(self, config: TrackConfig, camera_in_odom: Pose2D, measurement: CameraMeasurement) -> None:
        self._config = config
        self._kalman = _kalman_filter()
        range_m, range_sigma_m = measurement.range_m, measurement.range_sigma_m
        if measurement.bearing_only:
            # Anywhere between the lens and the bound, evenly likely.
            range_m, range_sigma_m = 0.5 * range_m, range_m / math.sqrt(12.0)
        direction_rad = camera_in_odom.yaw_rad + measurement.bearing_rad
        c, s = math.cos(direction_rad), math.sin(direction_rad)
        self._kalman.x = np.array(
            [[camera_in_odom.x_m + range_m * c], [camera_in_odom.y_m + range_m * s], [0.0], [0.0]]
        )
        # The position inherits the camera's constant errors: p = c + z_range / (1 + s) at z_bearing - b.
        jacobian = np.array(
            [
                [c, -range_m * s, -range_m * c, range_m * s],
                [s, range_m * c, -range_m * s, -range_m * c],
                [0.0, 0.0, 1.0, 0.0],
                [0.0, 0.0, 0.0, 1.0],
            ]
        )
        sigmas = np.array(
            [
                range_sigma_m,
                measurement.bearing_sigma_rad,
                config.camera_scale_sigma,
                config.camera_yaw_sigma_rad,
            ]
        )
        self._set_covariance((jacobian * sigmas**2) @ jacobian.T)

    def copy(self) -> TargetFilter:
        other = copy.copy(self)
        other._kalman = _kalman_filter()
        other._kalman.x, other._kalman.P = self._kalman.x.copy(), self._kalman.P.copy()
        return other

    @property
    def x_m(self) -> float:
        return float(self._kalman.x[0, 0])

    @property
    def y_m(self) -> float:
        return float(self._kalman.x[1, 0])

    @property
    def camera_scale_error(self) -> float:
        """By how much the camera's ranges are believed to be too long, of the range."""
        return float(self._kalman.x[2, 0])

    @property
    def camera_yaw_error_rad(self) -> float:
        """By how much the camera's bearings are believed to be too far left."""
        return float(self._kalman.x[3, 0])

    @property
    def covariance(self) -> FloatArray:
        """(4, 4), of (x, y, s, b)."""
        covariance: FloatArray = self._kalman.P
        return covariance

    @property
    def position_covariance(self) -> tuple[float, float, float]:
        """xx, xy, yy in m^2."""
        p = self._kalman.P
        return float(p[0, 0]), float(p[0, 1]), float(p[1, 1])

    def growth(
        self, robot: Pose2D, dt_s: float, travelled_m: float, turned_rad: float, drift_share: float = 1.0
    ) -> tuple[float, float, float]:
        """What a while without measurements adds to the position's covariance: xx, xy, yy in m^2.

        The target's own motion, and odometry's drift: of position with the way, and of heading with the way and with
        turning, which moves a target at range r by r sideways. Variances grow linearly: a random walk, of which
        `drift_share` counts.
        """
        config = self._config
        step_m = 0.5 * config.process_noise_mps2 * OWN_MOTION_S**2
        isotropic = step_m**2 * dt_s / OWN_MOTION_S + drift_share * config.drift_sigma**2 * travelled_m
        turn = drift_share * config.drift_yaw_sigma_rad**2 * (travelled_m + turned_rad)
        dx, dy = self.x_m - robot.x_m, self.y_m - robot.y_m
        return isotropic + turn * dy * dy, -turn * dx * dy, isotropic + turn * dx * dx

    def predict(self, growth: tuple[float, float, float]) -> None:
        """Add what `growth` said."""
        xx, xy, yy = growth
        # What KalmanFilter.predict does where nothing moves, in a tenth of its time.
        covariance = self._kalman.P
        covariance[0, 0] += xx
        covariance[0, 1] += xy
        covariance[1, 0] += xy
        covariance[1, 1] += yy

    def expect(self, camera_in_odom: Pose2D) -> CameraExpectation | None:
        """What the camera should measure from there; None for a target at the lens."""
        x_m, y_m, scale, yaw_error = self._kalman.x[:, 0].tolist()
        dx, dy = x_m - camera_in_odom.x_m, y_m - camera_in_odom.y_m
        distance_m = math.hypot(dx, dy)
        if distance_m < NEAREST_M:
            return None
        ux, uy = dx / distance_m, dy / distance_m
        jacobian = np.array(
            [
                [ux * (1.0 + scale), uy * (1.0 + scale), distance_m, 0.0],
                [-uy / distance_m, ux / distance_m, 0.0, 1.0],
            ]
        )
        (rr, rb), (_, bb) = (jacobian @ self._kalman.P @ jacobian.T).tolist()
        bearing_rad = wrap_angle(math.atan2(dy, dx) - camera_in_odom.yaw_rad + yaw_error)
        return CameraExpectation(distance_m * (1.0 + scale), bearing_rad, jacobian, rr, bb, rb)

    def update_camera(self, expected: CameraExpectation, measurement: CameraMeasurement) -> None:
        """Take a detection that `expected`, of this filter and not older than its last update, lets through."""
        off_rad = wrap_angle(measurement.bearing_rad - expected.bearing_rad)
        if measurement.bearing_only:
            jacobian = expected.jacobian[1:]
            innovation = np.array([[off_rad]])
            noise = np.array([[measurement.bearing_sigma_rad**2]])
        else:
            jacobian = expected.jacobian
            innovation = np.array([[measurement.range_m - expected.range_m], [off_rad]])
            noise = np.array([[measurement.range_sigma_m**2, 0.0], [0.0, measurement.bearing_sigma_rad**2]])
        self._update(innovation, jacobian, noise)

    def position_distance(
        self, x_m: float, y_m: float, covariance_m2: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    ) -> float:
        """Squared Mahalanobis distance of a position with its own covariance (xx, xy, yx, yy)."""
        xx, xy, yy = self.position_covariance
        xx, xy, yy = xx + covariance_m2[0], xy + covariance_m2[1], yy + covariance_m2[3]
        dx, dy = x_m - self.x_m, y_m - self.y_m
        return (dx * dx * yy - 2.0 * dx * dy * xy + dy * dy * xx) / (xx * yy - xy * xy)

    def update_position(
        self, x_m: float, y_m: float, covariance_m2: tuple[float, float, float, float]
    ) -> None:
        """Take a position in odom, as a LiDAR cluster gives it."""
        innovation = np.array([[x_m - self.x_m], [y_m - self.y_m]])
        self._update(innovation, np.eye(2, 4), np.array(covariance_m2).reshape(2, 2))

    def _update(self, innovation: FloatArray, jacobian: FloatArray, noise: FloatArray) -> None:
        self._kalman.update(innovation + jacobian @ self._kalman.x, R=noise, H=jacobian)
        self._set_covariance(self._kalman.P)

    def _set_covariance(self, covariance: FloatArray) -> None:
        covariance = 0.5 * (covariance + covariance.T)
        diagonal = covariance.ravel()[::5]  # a view, to be written through
        np.maximum(diagonal, MIN_VARIANCES, out=diagonal)
        self._kalman.P = covariance
