"""Everything the console is made of, and what it can be asked. What a question may do depends on who asks."""

from __future__ import annotations

import base64
import dataclasses
import re
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from target_nav.errors import ConfigError, MissionError, TargetNavError
from target_nav.gui.commands import CommandPort
from target_nav.gui.events import INFO, WARN
from target_nav.gui.missions import missions, targets
from target_nav.gui.model import Model
from target_nav.gui.settings import Change, Settings
from target_nav.state.live_settings import setting_text
from target_nav.state.types import CommandKind
from target_nav.web.access import Access, Role
from target_nav.web.desk import OperatorDesk
from target_nav.web.feed import Feed
from target_nav.web.helper import Helper
from target_nav.web.mission_files import MissionFolder

Arguments = Mapping[str, Any]
_RUN_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,99}")
MOST_RUNS = 200


class AccessRefused(TargetNavError):
    """A spectator asked for what only an operator may do."""


@dataclass(frozen=True)
class RawJson:
    """An answer that is JSON already."""

    text: str


class Console:
    """
    Args:
        config: what the stack runs with
        settings: where changes of settings go
        mission_folder: whose files may be read, changed and loaded
        runs: folder of runs, for recordings
        checker, recordings: helper processes that understand `check`, and `open` and `frame`
    """

    def __init__(
        self,
        prefix: str,
        access: Access,
        settings: Settings,
        mission_folder: Path,
        runs: Path,
        checker: Helper,
        recordings: Helper,
        wake: Callable[[], None],
    ) -> None:
        self.access, self.settings = access, settings
        self.files, self.runs = MissionFolder(mission_folder), runs
        self.checker, self.recordings = checker, recordings
        self.feed = Feed(Model(prefix, settings.config), wake)
        self.desk = OperatorDesk(CommandPort(prefix), lambda: self.settings.config)
        self.settings_version = 0
        """Counts changes, so that every page shows them."""
        self.files_version = 0

    async def close(self) -> None:
        await self.desk.close()
        await self.checker.close()
        await self.recordings.close()
        self.feed.close()

    async def answer(self, what: str, arguments: Arguments, role: Role, who: str) -> Any:
        """
        Raises:
            TargetNavError: it cannot be done; the text is for the person who asked.
        """
        question = QUESTIONS.get(what)
        if question is None:
            raise ConfigError(f"{what[:40]!r} is no question; there are {', '.join(QUESTIONS)}")
        if question.role is Role.OPERATOR and role is not Role.OPERATOR:
            raise AccessRefused(f"{what}: this is a spectator's address; open the operator's, with its token")
        try:
            return await question.handler(self, arguments, who)
        except (KeyError, TypeError, ValueError) as error:
            raise ConfigError(f"{what}: {type(error).__name__}: {error}") from error

    # -- words to the robot --------------------------------------------------------------------------------------------

    async def say(self, kind: CommandKind, argument: str, who: str) -> dict[str, Any]:
        shown = kind.name.replace("_", " ")
        said = await self.desk.say(kind, argument)
        level = INFO if said["acknowledged"] else WARN
        if kind is not CommandKind.SETTING or level is WARN:
            self.feed.note(
                f"{who}: {shown}{' ' + Path(argument).stem if argument else ''}: {said['text']}", level
            )
        return said

    async def load(self, arguments: Arguments, who: str) -> Any:
        name = str(arguments["mission"])
        choices = {Path(choice.path).name: choice.path for choice in missions(self.files.folder)}
        if name not in choices:
            raise MissionError(f"{name!r} is no mission; there are {', '.join(choices) or 'none'}")
        return await self.say(CommandKind.LOAD, choices[name], who)

    async def target(self, arguments: Arguments, who: str) -> Any:
        name = str(arguments.get("class", ""))
        if not name:
            return await self.say(CommandKind.TARGET, "", who)
        sizes_m = (arguments["height_m"], arguments["width_m"], arguments.get("lidar_width_m", 0.0))
        text = ",".join((name, *(f"{float(size):g}" for size in sizes_m)))
        return await self.say(CommandKind.TARGET, text, who)

    async def reset_odometry(self, arguments: Arguments, who: str) -> Any:
        said = await self.say(CommandKind.RESET_ODOM, "", who)
        if said["acknowledged"]:
            self.feed.clear_path()
        return said

    # -- missions ------------------------------------------------------------------------------------------------------

    async def list_missions(self, arguments: Arguments, who: str) -> Any:
        choices = missions(self.files.folder)
        return {
            "folder": str(self.files.folder),
            "writable": self.files.writable,
            "files": self.files.names(),
            "missions": [Path(choice.path).name for choice in choices],
            "targets": [dataclasses.asdict(spec) for spec in targets(choices)],
        }

    async def read_mission(self, arguments: Arguments, who: str) -> Any:
        return dataclasses.asdict(self.files.read(str(arguments["name"])))

    async def check_mission(self, arguments: Arguments, who: str) -> Any:
        name, text = str(arguments["name"]), str(arguments["text"])
        self.files.path_of(name)
        return await self.checker.ask("check", folder=str(self.files.folder), name=name, text=text)

    async def save_mission(self, arguments: Arguments, who: str) -> Any:
        """With errors only when forced: a file that cannot be loaded is of no use to a robot."""
        name, text = str(arguments["name"]), str(arguments["text"])
        version = arguments.get("version")
        self.files.path_of(name)
        forced = arguments.get("force") is True
        if not forced:
            problems = await self.check_mission(arguments, who)
            errors = [problem for problem in problems if problem["severity"] == "error"]
            if errors:
                first = errors[0]
                raise MissionError(
                    f"{name} is not saved: {len(errors)} error{'s' if len(errors) != 1 else ''}, first in line "
                    f"{first['line']}: {first['message']}"
                )
        saved = self.files.save(name, text, None if version is None else str(version))
        self.files_version += 1
        self.feed.note(f"{who}: saved {name}{' with its errors' if forced else ''}", WARN if forced else INFO)
        return dataclasses.asdict(saved)

    # -- settings ------------------------------------------------------------------------------------------------------

    async def list_settings(self, arguments: Arguments, who: str) -> Any:
        return {
            "sections": [dataclasses.asdict(section) for section in self.settings.sections()],
            "waiting_for_restart": list(self.settings.waiting_for_restart()),
            "path": str(self.settings.path) if self.settings.path is not None else "",
        }

    async def change_setting(self, arguments: Arguments, who: str) -> Any:
        return await self._changed(self.settings.change(str(arguments["key"]), arguments["value"]), who)

    async def reset_setting(self, arguments: Arguments, who: str) -> Any:
        return await self._changed(self.settings.reset(str(arguments["key"])), who)

    async def _changed(self, change: Change, who: str) -> Any:
        self.settings_version += 1
        self.feed.configure(self.settings.config)
        said = None
        if change.live:
            said = await self.say(CommandKind.SETTING, setting_text(change.key, change.value), who)
        self.feed.note(
            f"{who}: {change.key} = {change.value}{'' if change.live else ', from the next start on'}"
        )
        return {"key": change.key, "value": change.value, "live": change.live, "said": said}

    # -- the past ------------------------------------------------------------------------------------------------------

    async def past_frame(self, arguments: Arguments, who: str) -> Any:
        number = int(arguments["number"])
        found = self.feed.past(number)
        if found is None:
            raise ConfigError(f"frame {number} is not kept any more")
        frame, picture = found
        image = base64.b64encode(picture).decode() if picture is not None else ""
        return RawJson(f'{{"frame":{frame},"picture":"{image}"}}')

    async def list_runs(self, arguments: Arguments, who: str) -> Any:
        """Newest first."""
        if not self.runs.is_dir():
            return []
        folders = [
            f for f in self.runs.iterdir()
            if not f.is_symlink() and _RUN_NAME.fullmatch(f.name) and (f / "run.mcap").is_file()
        ]  # fmt: skip
        folders.sort(key=lambda f: f.name, reverse=True)
        return [{"name": f.name, "bytes": (f / "run.mcap").stat().st_size} for f in folders[:MOST_RUNS]]

    def _recording(self, arguments: Arguments) -> str:
        name = str(arguments["run"])
        if not _RUN_NAME.fullmatch(name) or not (self.runs / name / "run.mcap").is_file():
            raise ConfigError(f"{name[:100]!r} is no run of {self.runs}")
        return str((self.runs / name / "run.mcap").resolve())

    async def open_run(self, arguments: Arguments, who: str) -> Any:
        return await self.recordings.ask("open", path=self._recording(arguments))

    async def run_frame(self, arguments: Arguments, who: str) -> Any:
        number = int(arguments["number"])
        return RawJson(await self.recordings.ask("frame", path=self._recording(arguments), number=number))


Handler = Callable[[Console, Arguments, str], Awaitable[Any]]


@dataclass(frozen=True)
class Question:
    role: Role
    handler: Handler


def _word(kind: CommandKind) -> Question:
    async def handler(console: Console, arguments: Arguments, who: str) -> Any:
        return await console.say(kind, "", who)

    return Question(Role.OPERATOR, handler)


QUESTIONS: dict[str, Question] = {
    "go": _word(CommandKind.GO),
    "stop": _word(CommandKind.STOP),
    "pause": _word(CommandKind.PAUSE),
    "resume": _word(CommandKind.RESUME),
    "step": _word(CommandKind.STEP),
    "reload": _word(CommandKind.RELOAD),
    "reset_odometry": Question(Role.OPERATOR, Console.reset_odometry),
    "load": Question(Role.OPERATOR, Console.load),
    "target": Question(Role.OPERATOR, Console.target),
    "missions": Question(Role.SPECTATOR, Console.list_missions),
    "mission.read": Question(Role.SPECTATOR, Console.read_mission),
    # it costs a core while somebody types, so not for everybody
    "mission.check": Question(Role.OPERATOR, Console.check_mission),
    "mission.save": Question(Role.OPERATOR, Console.save_mission),
    "settings": Question(Role.SPECTATOR, Console.list_settings),
    "setting.change": Question(Role.OPERATOR, Console.change_setting),
    "setting.reset": Question(Role.OPERATOR, Console.reset_setting),
    "past": Question(Role.SPECTATOR, Console.past_frame),
    "runs": Question(Role.SPECTATOR, Console.list_runs),
    "run.open": Question(Role.SPECTATOR, Console.open_run),
    "run.frame": Question(Role.SPECTATOR, Console.run_frame),
}
