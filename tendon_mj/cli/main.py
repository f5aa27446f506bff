"""The command line's commands, and its exit status."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from importlib.metadata import version

import tyro

from tendon_mj.cli.attach import attach
from tendon_mj.cli.bench import bench
from tendon_mj.cli.check import check
from tendon_mj.cli.compare import compare
from tendon_mj.cli.demo import demo
from tendon_mj.cli.diagnose import diagnose
from tendon_mj.cli.init import init
from tendon_mj.cli.render import render
from tendon_mj.cli.replay import replay
from tendon_mj.cli.simulate import simulate
from tendon_mj.cli.view import view
from tendon_mj.errors import TendonError

COMMANDS: dict[str, Callable[..., object]] = {
    "attach": attach,
    "bench": bench,
    "compare": compare,
    "init": init,
    "check": check,
    "replay": replay,
    "diagnose": diagnose,
    "render": render,
    "simulate": simulate,
    "view": view,
    "demo": demo,
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; returns 0 on success, 2 when its input was refused, 130 when stopped."""
    if list(sys.argv[1:] if arguments is None else arguments) == ["--version"]:
        print(f"tendon-mj {version('tendon-mj')}")
        return 0
    try:
        tyro.extras.subcommand_cli_from_dict(
            COMMANDS,
            prog="tendon-mj",
            description="Tendon-sheath friction for MuJoCo.",
            args=None if arguments is None else list(arguments),
        )
    except (TendonError, OSError) as error:
        line = "; ".join(str(error).splitlines())  # MuJoCo's messages have several
        print(f"tendon-mj: {line}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("tendon-mj: stopped; files written so far are kept", file=sys.stderr)
        return 130
    return 0
