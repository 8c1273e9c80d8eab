"""The helper process: answers, errors, and what becomes of one that hangs or dies."""

from __future__ import annotations

import asyncio
import sys
import time

import pytest

from target_nav.errors import DeviceError
from target_nav.web.helper import Helper, HelperError

PROGRAM = """
import json, os, sys, time
for line in sys.stdin:
    question = json.loads(line)
    what = question["what"]
    if what == "hang": time.sleep(60)
    if what == "die": os._exit(3)
    print(json.dumps({"error": "no"} if what == "fail" else {"value": [what, os.getpid()]}), flush=True)
"""
ARGV = (sys.executable, "-c", PROGRAM)


def test_one_process_answers_until_nobody_asks() -> None:
    async def run() -> None:
        helper = Helper(ARGV, patience_s=20.0, idle_s=0.2)
        assert not helper.running
        first, second = await helper.ask("a"), await helper.ask("b")
        assert (first[0], second[0]) == ("a", "b")
        assert first[1] == second[1]
        with pytest.raises(HelperError, match="no"):
            await helper.ask("fail")
        deadline_s = time.monotonic() + 20.0
        while helper.running:
            assert time.monotonic() < deadline_s, "it ends when nobody asks"
            await asyncio.sleep(0.02)
        await helper.close()

    asyncio.run(run())


def test_one_that_hangs_or_dies_is_told_and_the_next_question_gets_a_new_one() -> None:
    async def run() -> None:
        helper = Helper(ARGV, patience_s=1.0)
        with pytest.raises(DeviceError, match="no answer within 1 s"):
            await helper.ask("hang")
        helper = Helper(ARGV, patience_s=20.0)
        with pytest.raises(DeviceError, match="died"):
            await helper.ask("die")
        assert (await helper.ask("again"))[0] == "again"
        await helper.close()
        assert not helper.running

    asyncio.run(run())
