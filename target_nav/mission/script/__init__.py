"""The scripting language of missions: `_skipIf="battery < 20"`, `<Script code="tries += 1; state := 'found'"/>`.

`parse_script` reads a text (`tokens`, `grammar`) into what it means (`syntax`); `kinds_of` tells before it runs what
cannot work; `bind` connects it with blackboard entries and gives a function to call.
"""

from __future__ import annotations

from target_nav.mission.script.arithmetic import Enums, as_text, number_in, truth
from target_nav.mission.script.evaluate import Run, ScriptEntry, bind
from target_nav.mission.script.grammar import parse_script
from target_nav.mission.script.kinds import check_kinds
from target_nav.mission.script.syntax import Script, ScriptError

__all__ = [
    "Enums",
    "Run",
    "Script",
    "ScriptEntry",
    "ScriptError",
    "as_text",
    "bind",
    "check_kinds",
    "number_in",
    "parse_script",
    "truth",
]
