"""Runs an experiment as a command, with its errors as one line."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence

import tyro

from tendon_mj.errors import TendonError


def run_experiment(
    experiment: Callable[..., None], name: str, arguments: Sequence[str] | None = None
) -> int:
    """Run ``python -m experiments.<name>``; return 0, or 2 when the input was refused.

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
    return 0
