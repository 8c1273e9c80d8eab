"""A launch plan as actions of ROS 2's `launch`. The only module that needs it."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import Any

from launch import LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    EmitEvent,
    ExecuteProcess,
    LogInfo,
    OpaqueFunction,
    TimerAction,
)
from launch.events import Shutdown

from target_nav.app.launch_plan import Answer, ExitRule, Plan, PlannedProcess

Arguments = Mapping[str, tuple[str, str]]


def describe(arguments: Arguments, make_plan: Callable[[Mapping[str, str]], Plan]) -> LaunchDescription:
    """A launch file: `arguments` are name to default and description, `make_plan` gets their values."""

    def start(context: Any) -> list[Any]:
        plan = make_plan({name: context.launch_configurations[name] for name in arguments})
        notes = [LogInfo(msg=note) for note in (f"everything goes to {plan.run_dir}/", *plan.notes)]
        return [*notes, *(_execute(process, ExitRule(process.spec)) for process in plan.processes)]

    declared = [
        DeclareLaunchArgument(name, default_value=default, description=text)
        for name, (default, text) in arguments.items()
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=start)])


def _execute(process: PlannedProcess, rule: ExitRule) -> ExecuteProcess:
    def ended(event: Any, context: Any) -> list[Any] | None:
        if context.is_shutdown:
            return None
        answer, delay_s, text = rule.answer(time.monotonic(), event.returncode)
        told = LogInfo(msg=text)
        if answer is Answer.RESTART:
            return [told, TimerAction(period=delay_s, actions=[_execute(process, rule)])]
        if answer is Answer.STOP_ALL:
            return [told, EmitEvent(event=Shutdown(reason=text))]
        return [told]

    return ExecuteProcess(
        cmd=list(process.command),
        name=process.spec.name,
        additional_env=dict(process.environment),
        output="both",
        on_exit=ended,
    )
