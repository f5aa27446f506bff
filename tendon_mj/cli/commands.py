"""The commands, their help, and the exit status of the command line."""

from __future__ import annotations

import inspect
import os
import re
import shlex
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from importlib.metadata import version
from io import TextIOWrapper
from types import FunctionType
from typing import cast

import tyro

from tendon_mj.cli.attach import attach
from tendon_mj.cli.bench import bench
from tendon_mj.cli.compare import compare
from tendon_mj.cli.demo import demo
from tendon_mj.cli.diagnose import diagnose
from tendon_mj.cli.fleet import fleet
from tendon_mj.cli.given_files import typed_command
from tendon_mj.cli.recordings import check, init, replay
from tendon_mj.cli.render import render, view
from tendon_mj.cli.simulate import simulate
from tendon_mj.cli.sweep import sweep
from tendon_mj.errors import RecordingError, TendonError

_Command = Callable[..., object]

COMMANDS: dict[str, _Command] = {
    "attach": attach,
    "bench": bench,
    "compare": compare,
    "init": init,
    "check": check,
    "replay": replay,
    "diagnose": diagnose,
    "render": render,
    "simulate": simulate,
    "sweep": sweep,
    "fleet": fleet,
    "view": view,
    "demo": demo,
}

_INTERRUPTED = 130  # status of a process that Ctrl-C ends, in a shell
_EXAMPLE = re.compile(r"\n+ *Example:\n((?: +.*\n?)+?)(?=\n|\Z)")
_CONTINUED = re.compile(r"\n {8,}")  # a further line of the description of an argument


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; returns 0 on success, 2 when its input was refused, 130 after Ctrl-C."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # a terminal that has no µ or °
    typed_command.set(shlex.join(["tendon-mj", *given]))
    try:
        with _short_warnings():
            _run(given)
    except KeyboardInterrupt:
        return _interrupted()
    except BrokenPipeError:  # the reader has enough, as `head`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except (TendonError, OSError, UnicodeError) as error:
        if _follows_ctrl_c(error):
            return _interrupted()
        # a recording has a line for each fault; MuJoCo's messages have several lines
        text = str(error)
        text = text if isinstance(error, RecordingError) else "; ".join(text.splitlines())
        print(f"tendon-mj: {text}", file=sys.stderr)
        return 2
    return 0


def _run(given: Sequence[str]) -> None:
    if "" in given:
        raise TendonError("an argument is empty, perhaps that of an unset variable of the shell")
    try:
        if given == ["--version"]:
            print(f"tendon-mj {version('tendon-mj')}")
        else:
            tyro.extras.subcommand_cli_from_dict(
                {name: documented(command) for name, command in COMMANDS.items()},
                prog="tendon-mj",
                description="Tendon-sheath friction for MuJoCo.",
                args=given,
            )
    except SystemExit as end:  # of --help, and of arguments that are refused
        if not end.code and given[:1] and given[0] in COMMANDS:
            print(f"example:\n  {example(COMMANDS[given[0]])}")
        raise
    finally:
        sys.stdout.flush()  # where a broken pipe is caught


def example(command: _Command) -> str:
    """The line below `Example:` in a command's docstring; empty where it has none."""
    match = _EXAMPLE.search(inspect.getdoc(command) or "")
    return match[1].strip() if match else ""


def documented(command: _Command) -> _Command:
    """A command with each argument of its docstring in one line, for the terminal to wrap.

    The example is left out; `example` has it.
    """
    given = cast(FunctionType, command)
    same = FunctionType(given.__code__, given.__globals__, given.__name__, given.__defaults__)
    same.__annotations__, same.__kwdefaults__ = given.__annotations__, given.__kwdefaults__
    same.__doc__ = _CONTINUED.sub(" ", _EXAMPLE.sub("", inspect.getdoc(given) or ""))
    return same


@contextmanager
def _short_warnings() -> Iterator[None]:
    """Format Python's warnings in one line, without their place in the code."""

    def formatted(message: Warning | str, *_: object, **__: object) -> str:
        return f"warning: {'; '.join(str(message).splitlines())}\n"

    before, warnings.formatwarning = warnings.formatwarning, formatted
    try:
        yield
    finally:
        warnings.formatwarning = before


def _interrupted() -> int:
    print(
        "tendon-mj: interrupted; the files written so far are whole, the others are missing",
        file=sys.stderr,
    )
    return _INTERRUPTED


def _follows_ctrl_c(error: BaseException | None) -> bool:
    """Whether Ctrl-C led to an error, as when it ends ffmpeg too."""
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__cause__ or error.__context__
    return error is not None
