"""All view models of one stack, from one look at shared memory: what a screen draws of."""

from __future__ import annotations

from dataclasses import dataclass

from target_nav.config import Config
from target_nav.gui.events import Event, EventLog
from target_nav.gui.source import StackReader, World
from target_nav.gui.view_arrival import ArrivalView, arrival_view
from target_nav.gui.view_camera import CameraView, camera_view
from target_nav.gui.view_map import MapModel, MapView
from target_nav.gui.view_radar import RadarView, radar_view
from target_nav.gui.view_status import StatusView, status_view
from target_nav.gui.view_tree import TreeView, tree_view


@dataclass(frozen=True, eq=False)
class Views:
    """One consistent picture; `plain.to_plain` makes JSON values of it."""

    now_s: float
    status: StatusView
    camera: CameraView
    radar: RadarView
    map: MapView
    tree: TreeView
    arrival: ArrivalView
    events: tuple[Event, ...]


class Model:
    """Reads and remembers. `look` belongs to one thread; what it returns is frozen and may go to any.

    Args:
        prefix: of the channels
        config: the stack's configuration: the body's size, limits of age
        pictures: whether camera pictures are wanted
    """

    def __init__(self, prefix: str, config: Config, pictures: bool = True) -> None:
        self.config = config
        """May be replaced by another one, when settings change."""
        self.log = EventLog()
        self.world: World | None = None
        self._reader = StackReader(prefix, config, pictures)
        self._map = MapModel()

    def look(self, now_s: float) -> Views:
        """`now_s` is monotonic time."""
        world = self.world = self._reader.poll(now_s)
        config = self.config
        status = status_view(world, config)
        self.log.see(status)
        return Views(
            now_s=now_s,
            status=status,
            camera=camera_view(world, config.camera.width_px, config.camera.height_px),
            radar=radar_view(world, config.robot),
            map=self._map.view(world),
            tree=tree_view(world),
            arrival=arrival_view(world, config),
            events=self.log.events,
        )

    def clear_path(self) -> None:
        self._map.clear()

    def close(self) -> None:
        self._reader.close()
