"""`target-nav test`: missions against scripted blackboards, in virtual time, without a robot."""

from __future__ import annotations

import time
from fnmatch import fnmatchcase
from pathlib import Path

import click

from target_nav.app.paths import mission_path
from target_nav.errors import MissionError
from target_nav.mission.scenario_file import read_scenarios
from target_nav.mission.scenario_find import find_scenario_files
from target_nav.mission.scenario_model import Scenario
from target_nav.mission.scenario_run import ScenarioResult, run_scenario


@click.command(name="test")
@click.argument("files", nargs=-1)
@click.option(
    "-k", "pattern", default="*", metavar="PATTERN", help="Only scenarios whose name has it; * and ? work."
)
@click.option("-x", "stop_early", is_flag=True, help="Stop at the first that fails.")
@click.option("-v", "--verbose", is_flag=True, help="Show what happened in those that pass as well.")
@click.pass_context
def command(
    ctx: click.Context, files: tuple[str, ...], pattern: str, stop_early: bool, verbose: bool
) -> None:
    """Run scenarios: FILE is a scenario file, a folder of them, or a mission (or its name
    in trees/) with its scenarios beside it.

    Without FILE all that come along. Exit 0: all passed; 1: one failed; 2: one could not be run.
    """
    begin_s = time.monotonic()
    passed = failed = broken = 0
    for path in find_scenario_files(mission_path(file) for file in files):
        try:
            scenarios = read_scenarios(path)
        except MissionError as error:
            click.echo(str(error), err=True)
            broken += 1
            continue
        for scenario in scenarios:
            if not _wanted(scenario, pattern):
                continue
            try:
                result = run_scenario(scenario)
            except MissionError as error:
                click.echo(str(error), err=True)
                broken += 1
                continue
            passed, failed = passed + result.passed, failed + (not result.passed)
            _tell(result, verbose)
            if failed and stop_early:
                ctx.exit(1)
    total = passed + failed
    words = [
        f"{passed} passed",
        *([f"{failed} failed"] if failed else []),
        *([f"{broken} broken"] if broken else []),
    ]
    click.echo(
        f"{total} scenario{'s' if total != 1 else ''}: {', '.join(words)} in {time.monotonic() - begin_s:.1f} s"
    )
    ctx.exit(2 if broken or not total else 1 if failed else 0)


def _wanted(scenario: Scenario, pattern: str) -> bool:
    return fnmatchcase(scenario.name.casefold(), f"*{pattern.casefold()}*")


def _tell(result: ScenarioResult, verbose: bool) -> None:
    scenario = result.scenario
    mark = click.style("ok    ", fg="green") if result.passed else click.style("FAILED", fg="red")
    click.echo(f"{mark}  {Path(scenario.place.file).name}: {scenario.name}  ({scenario.lasts_s:g} s)")
    if verbose or not result.passed:
        click.echo(result.explain() + "\n")
