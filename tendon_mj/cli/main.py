"""The command line's commands, and its exit status."""

from __future__ import annotations

import errno
import os
import sys
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from importlib.metadata import version
from io import TextIOWrapper
from pathlib import Path

import tyro

from tendon_mj.cli.attach import attach
from tendon_mj.cli.bench import bench
from tendon_mj.cli.check import check
from tendon_mj.cli.compare import compare
from tendon_mj.cli.demo import demo
from tendon_mj.cli.diagnose import diagnose
from tendon_mj.cli.fleet import fleet
from tendon_mj.cli.help import Command, documented, example
from tendon_mj.cli.init import init
from tendon_mj.cli.interruption import pressed
from tendon_mj.cli.render import render
from tendon_mj.cli.repeated_options import gathered, options_of_several
from tendon_mj.cli.replay import replay
from tendon_mj.cli.simulate import simulate
from tendon_mj.cli.sweep import sweep
from tendon_mj.cli.view import view
from tendon_mj.errors import RecordingError, TendonError

COMMANDS: dict[str, Command] = {
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


_INTERRUPTED = 130  # as a shell has it for a process that Ctrl-C ends


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; returns 0 on success, 2 when its input was refused, 130 after Ctrl-C."""
    given = list(sys.argv[1:] if arguments is None else arguments)
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # it was closed, as by >&-, which tyro does not expect
            setattr(sys, name, Path(os.devnull).open("w", encoding="utf-8"))  # noqa: SIM115
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # a terminal that has no µ or °
    refused = _empty_argument(given) or _unwritable_argument(given)
    if refused:
        return _refused(refused)
    try:
        try:
            with _warnings_in_a_line():
                return _run(given)
        finally:
            sys.stdout.flush()  # not as Python ends, which would tell of it in its own way
    except OSError as error:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if isinstance(error, BrokenPipeError):  # who reads the output has enough, as `head`
            return 0
        return _refused(f"the standard output: {error.strerror}")


def _run(given: Sequence[str]) -> int:
    if given == ["--version"]:
        print(f"tendon-mj {version('tendon-mj')}")
        return 0
    try:
        tyro.extras.subcommand_cli_from_dict(
            {name: documented(command) for name, command in COMMANDS.items()},
            prog="tendon-mj",
            description="Tendon-sheath friction for MuJoCo.",
            args=gathered(given, options_of_several(COMMANDS.values())),
        )
    except SystemExit as end:  # of --help, and of arguments that are refused
        if not end.code and given[:1] and given[0] in COMMANDS:
            print(f"example:\n  {example(COMMANDS[given[0]])}")
        raise
    except Exception as error:
        if pressed() or _is_interruption(error):
            return _interrupted()
        if not isinstance(error, TendonError | OSError) or _is_of_output(error):
            raise
        if isinstance(error, RecordingError):  # a line for each fault of a file
            return _refused(str(error))
        return _refused("; ".join(str(error).splitlines()))  # MuJoCo's messages have several
    except KeyboardInterrupt:
        return _interrupted()
    return 0


@contextmanager
def _warnings_in_a_line() -> Iterator[None]:
    """Python's warnings as the command line tells its own: without the place in the code."""
    before = warnings.formatwarning

    def told(
        message: Warning | str,
        category: type[Warning],
        filename: str,
        lineno: int,
        line: str | None = None,
    ) -> str:
        return f"warning: {'; '.join(str(message).splitlines())}\n"

    warnings.formatwarning = told
    try:
        yield
    finally:
        warnings.formatwarning = before


def _unwritable_argument(given: Sequence[str]) -> str:
    """Message that an argument's bytes are no text, as those of a file's name may be; or nothing.

    Such a name can be written into no result and no picture.
    """
    for argument in given:
        try:
            argument.encode()
        except UnicodeEncodeError:
            return f"argument {argument!a}: its bytes are not UTF-8; rename the file"
    return ""


def _empty_argument(given: Sequence[str]) -> str:
    """Message that an argument, or the value behind an option's ``=``, is empty; or nothing.

    An empty path would be the current folder.
    """
    for k, argument in enumerate(given):
        option, equals, value = argument.partition("=")
        if option.startswith("--") and equals and not value:
            return f"the argument after {option} is empty"
        if not argument:
            return f"the argument after {given[k - 1]} is empty" if k else "the argument is empty"
    return ""


def _interrupted() -> int:
    print(
        "tendon-mj: interrupted; the files written so far are whole, the others are missing",
        file=sys.stderr,
    )
    return _INTERRUPTED


def _refused(why: str) -> int:
    """Say why on the standard error, if anybody reads it."""
    with suppress(OSError):
        print(f"tendon-mj: {why}", file=sys.stderr)
    return 2


def _is_of_output(error: Exception) -> bool:
    """Whether the standard output takes no more: errors of files name the file."""
    full = (errno.ENOSPC, errno.EPIPE)
    return isinstance(error, OSError) and error.filename is None and error.errno in full


def _is_interruption(error: BaseException | None) -> bool:
    """Whether an error came up on the way out after Ctrl-C, which ends ffmpeg too."""
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__cause__ or error.__context__
    return error is not None
