"""The thread that looks: ten times a second at shared memory, into sections that all viewers share.

Viewers never reach the channels, so their number changes nothing for whoever writes those.
"""

from __future__ import annotations

import json
import logging
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field

import cv2

from target_nav.config import Config
from target_nav.gui.events import INFO
from target_nav.gui.model import Model, Views
from target_nav.gui.plain import to_plain
from target_nav.state.live_settings import fingerprint
from target_nav.web.encode import dumps, events_section, joined, map_section, sections_of
from target_nav.web.pictures import PAST_PERIOD_S, PAST_QUALITY, PAST_WIDTH_PX, PERIOD_S, Rate, jpeg
from target_nav.web.timeline import Mark, Timeline

log = logging.getLogger(__name__)

LOOK_PERIOD_S = 0.1
MAP_PERIOD_S = 0.5
SAY_AGAIN_S = 10.0
RADAR_EVERY = 4
"""Frames of the timeline that share one scan."""


@dataclass(frozen=True)
class Picture:
    """`number` counts the pictures of this feed."""

    number: int
    stamp_s: float
    data: bytes


@dataclass(frozen=True)
class Look:
    """What the newest look saw. `versions`: of each section the look in which it last changed."""

    number: int = 0
    now_s: float = 0.0
    sections: dict[str, str] = field(default_factory=dict)
    versions: dict[str, int] = field(default_factory=dict)
    picture: Picture | None = None


class Feed:
    """
    Args:
        model: the view models; from `start` on only the feed's thread touches it
        wake: called in that thread after every look
    """

    def __init__(
        self, model: Model, wake: Callable[[], None], clock: Callable[[], float] = time.monotonic
    ) -> None:
        self.latest = Look()
        self.timeline = Timeline()
        self.lock = threading.Lock()
        """Of the timeline."""
        self.pictures_wanted = False
        self._model, self._wake, self._clock = model, wake, clock
        self._config: Config = model.config
        self._new_config: Config | None = None
        self._notes: list[tuple[str, str]] = []
        self._clear_path = False
        self._picture: Picture | None = None
        self._picture_rate, self._past_rate = Rate(PERIOD_S), Rate(PAST_PERIOD_S)
        self._map_rate = Rate(MAP_PERIOD_S)
        self._frame_id = self._past_frame_id = -1
        self._complained_s = -SAY_AGAIN_S
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="feed", daemon=True)

    def start(self) -> None:
        # One core is a lot for somebody who only watches.
        cv2.setNumThreads(1)
        self._thread.start()

    def close(self) -> None:
        self._stop.set()
        if self._thread.is_alive():
            self._thread.join()
        self._model.close()

    def note(self, text: str, level: str = INFO) -> None:
        """A line for the event log."""
        self._notes.append((text, level))

    def configure(self, config: Config) -> None:
        """Settings have changed."""
        self._new_config = config

    def clear_path(self) -> None:
        self._clear_path = True

    def past(self, number: int) -> tuple[str, bytes | None] | None:
        """A frame of the timeline with all its sections, as JSON, and the picture that goes with it."""
        with self.lock:
            own, picture = self.timeline.frame(number), self.timeline.picture(number)
            older = self.timeline.frame(max(number - number % RADAR_EVERY, self.timeline.begin))
        if own is None:
            return None
        if own == older or older is None:
            return own, picture
        return dumps({**json.loads(older), **json.loads(own)}), picture

    # -- in the thread -------------------------------------------------------------------------------------------------

    def _run(self) -> None:
        next_s = self._clock()
        while not self._stop.is_set():
            now_s = self._clock()
            try:
                self.look(now_s)
            except Exception:
                # What stands in shared memory may be anything; a console that dies of it helps nobody.
                if now_s - self._complained_s > SAY_AGAIN_S:
                    self._complained_s = now_s
                    log.exception("this look at shared memory failed")
            self._wake()
            next_s = max(next_s + LOOK_PERIOD_S, now_s + 0.25 * LOOK_PERIOD_S)
            self._stop.wait(max(0.0, next_s - self._clock()))

    def look(self, now_s: float) -> None:
        """One look, in whose thread ever."""
        self._take_requests()
        views = self._model.look(now_s)
        sections = sections_of(views)
        self._remember(views, sections)
        sections["events"] = events_section(views.events)
        sections["console"] = dumps(self._console(views))
        if self._map_rate.due(now_s):
            sections["map"] = map_section(views.map)
        self._encode(views)
        before, number = self.latest, self.latest.number + 1
        versions = dict(before.versions)
        versions.update(
            {name: number for name, text in sections.items() if before.sections.get(name) != text}
        )
        self.latest = Look(number, now_s, {**before.sections, **sections}, versions, self._picture)

    def _take_requests(self) -> None:
        config, self._new_config = self._new_config, None
        if config is not None:
            self._model.config = self._config = config
        notes, self._notes = self._notes, []
        for text, level in notes:
            self._model.log.add(text, level)
        if self._clear_path:
            self._clear_path = False
            self._model.clear_path()

    def _console(self, views: Views) -> dict[str, object]:
        world = self._model.world
        nav = world.nav.value if world is not None else None
        return {
            "now_s": round(views.now_s, 3),
            "settings_taken": nav is None or nav.settings_crc == fingerprint(self._config),
        }

    def _encode(self, views: Views) -> None:
        image, frame_id = views.camera.image_bgr, views.camera.frame_id
        if image is None or frame_id == self._frame_id or not self.pictures_wanted:
            return
        if self._picture_rate.due(views.now_s):
            self._frame_id = frame_id
            number = self._picture.number + 1 if self._picture is not None else 1
            self._picture = Picture(number, views.now_s - views.camera.age_s, jpeg(image))

    def _remember(self, views: Views, sections: dict[str, str]) -> None:
        if views.status.state == "":
            return
        picture = None
        camera = views.camera
        if (
            camera.image_bgr is not None
            and camera.fresh
            and camera.frame_id != self._past_frame_id
            and self._past_rate.due(views.now_s)
        ):
            self._past_frame_id = camera.frame_id
            picture = jpeg(camera.image_bgr, PAST_WIDTH_PX, PAST_QUALITY)
        status = views.status
        pose = dumps(to_plain(views.map.pose))
        # a scan is most of a frame, and its noise cannot be packed
        kept = {n: t for n, t in sections.items() if n != "radar" or self.timeline.end % RADAR_EVERY == 0}
        mark = Mark(
            views.now_s,
            # thousands of marks, a dozen words
            sys.intern(status.state),
            sys.intern(status.leaf),
            any(not (link.fresh or link.quiet) for link in status.links),
        )
        with self.lock:
            self.timeline.add(mark, f'{{"pose":{pose},{joined(kept)}}}', picture)
