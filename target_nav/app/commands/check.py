"""`target-nav check`: everything wrong with mission files, all of it at once."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import click

from target_nav.app.output_file import write_output
from target_nav.app.paths import mission_path
from target_nav.config import Config
from target_nav.mission import default_registry
from target_nav.mission.check import analyse
from target_nav.mission.lint import lint
from target_nav.mission.problems import Problem
from target_nav.mission.xsd import write_xsd


@click.command(name="check")
@click.argument("files", nargs=-1)
@click.option("--strict", is_flag=True, help="Warnings fail as well.")
@click.option("--json", "as_json", is_flag=True, help="For programs: one JSON object.")
@click.option(
    "--xsd",
    "schema",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Write an XML schema of missions, for editors; FILES may be left out then.",
)
@click.pass_context
def command(
    ctx: click.Context, files: tuple[str, ...], strict: bool, as_json: bool, schema: Path | None
) -> None:
    """Check mission files, XML or YAML, or names of those in trees/. Exit 1 when anything is wrong.

    An error keeps a mission from running. A warning is of something that is allowed and hardly meant: a key that
    nobody reads, a node that is never ticked, a search without an end.
    """
    if schema is not None:
        write_output(schema, write_xsd(default_registry()))
    elif not files:
        raise click.UsageError("no mission file is named")
    problems = [problem for file in files for problem in problems_of(mission_path(file))]
    errors = sum(problem.severity == "error" for problem in problems)
    warnings = len(problems) - errors
    if as_json:
        click.echo(_json(files, problems, errors, warnings))
    else:
        for problem in problems:
            click.echo(str(problem))
        if files:
            click.echo(_summary(len(files), errors, warnings))
    ctx.exit(1 if errors or (strict and warnings) else 0)


def problems_of(path: Path) -> list[Problem]:
    """What the loader would refuse, and what it would not but a person should know; in the order of reading."""
    analysis = analyse(path)
    found = {*analysis.problems, *lint(analysis, tick_s=1.0 / Config().loop.rate_hz)}
    files = [file.shown for file in analysis.library.files]
    order = {name: number for number, name in enumerate(files)}
    return sorted(
        found, key=lambda p: (order.get(p.file, len(order)), p.line, p.column, p.severity, p.message)
    )


def _summary(files: int, errors: int, warnings: int) -> str:
    where = f"{files} mission file{'s' if files != 1 else ''}"
    counts = [
        f"{n} {what}{'s' if n != 1 else ''}" for n, what in ((errors, "error"), (warnings, "warning")) if n
    ]
    return f"{where}: {', '.join(counts) or 'nothing wrong'}"


def _json(files: Sequence[str], problems: Sequence[Problem], errors: int, warnings: int) -> str:
    return json.dumps(
        {
            "files": list(files),
            "errors": errors,
            "warnings": warnings,
            "problems": [
                {
                    "file": problem.file,
                    "line": problem.line,
                    "column": problem.column,
                    "severity": problem.severity,
                    "message": problem.message,
                }
                for problem in problems
            ],
        },
        indent=2,
    )
