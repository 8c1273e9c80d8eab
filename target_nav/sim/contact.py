"""Does the footprint touch anything, and how near did it ever come? Asked at each step, so it must cost little."""

from __future__ import annotations

from target_nav.sim.world import World


class ContactMonitor:
    """No point of the footprint can come nearer to anything than by the way it moved.

    So the exact clearance is worked out only when the last one, less the way since, could be a new minimum.
    """

    def __init__(self, world: World, x_m: float, y_m: float, yaw_rad: float) -> None:
        self._world = world
        self.min_clearance_m = world.clearance_m(x_m, y_m, yaw_rad)
        self._at_least_m = self.min_clearance_m
        self.collided = self.min_clearance_m <= 0.0

    def disturb(self, x_m: float, y_m: float, yaw_rad: float, travel_m: float) -> None:
        """Something moved by `travel_m`, and the robot is there: it may touch by that alone."""
        self.admits(x_m, y_m, yaw_rad, travel_m)

    def admits(self, x_m: float, y_m: float, yaw_rad: float, travel_m: float) -> bool:
        """May the robot be there? `travel_m` bounds how far any point of the footprint moved to get there.

        False when it would touch: the robot stays where it was, which `collided` remembers for good.
        """
        self._at_least_m -= travel_m
        if self._at_least_m > self.min_clearance_m:
            return True
        clearance_m = self._world.clearance_m(x_m, y_m, yaw_rad)
        if clearance_m <= 0.0:
            self.collided = True
            self.min_clearance_m = 0.0
            self._at_least_m = 0.0
            return False
        self._at_least_m = clearance_m
        if clearance_m < self.min_clearance_m:
            self.min_clearance_m = clearance_m
        return True
