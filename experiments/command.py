"""Shared by the commands of experiments: errors in a line, measured data, written results."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

import tyro
from matplotlib.figure import Figure

from tendon_mj.cli import Output, console
from tendon_mj.errors import RecordingError, TendonError
from tendon_mj.whole_file import whole_file


def run_experiment(
    experiment: Callable[..., None], name: str, arguments: Sequence[str] | None = None
) -> int:
    """Run ``python -m experiments.<name>``; return 0, 2 when refused, 130 after Ctrl-C.

    Args:
        experiment: function whose arguments become options and whose docstring the help.
        name: of the package under `experiments`.
        arguments: of the command line; None takes those of the process.
    """
    program = f"python -m experiments.{name}"
    try:
        tyro.cli(experiment, prog=program, args=arguments)
    except (TendonError, OSError) as error:
        print(f"{program}: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print(f"{program}: interrupted", file=sys.stderr)
        return 130
    return 0


def measured_data(name: str) -> Path:
    """File or folder of measurements below the folder that TENDON_MJ_DATA names.

    Raises:
        RecordingError: the variable is not set.
    """
    root = os.environ.get("TENDON_MJ_DATA")
    if not root:
        raise RecordingError(
            f"give --data, or set TENDON_MJ_DATA to a folder that has {name} (see docs/data.md)"
        )
    return Path(root) / name


def write_study(
    output: Output,
    figures: Iterable[tuple[str, Figure]],
    result: Mapping[str, object],
    table: str,
    summary: Iterable[str],
) -> None:
    """Write pictures, result.json and table.md of a study, print its summary, and close."""
    for name, figure in figures:
        output.figure(name, figure)
    output.result(result)
    page = output.add(output.folder / "table.md")
    with whole_file(page) as made:
        made.write_text(table, encoding="utf-8")
    for line in summary:
        console.print(line, soft_wrap=True)
    output.close()
