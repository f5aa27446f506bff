"""The commands, their help, and the exit status of the command line."""

from __future__ import annotations

import ast
import inspect
import re
import shlex
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module, resources
from importlib.metadata import version
from io import TextIOWrapper
from typing import cast

import tyro

from tendon_mj.cli.output import typed_command
from tendon_mj.errors import MissingPackageError, RecordingError, TendonError

CommandFunction = Callable[..., object]

COMMANDS = {  # name → module, which is loaded when the command is called
    "attach": "attach",
    "bench": "bench",
    "compare": "bench",
    "init": "recordings",
    "check": "recordings",
    "replay": "recordings",
    "diagnose": "diagnose",
    "render": "motion",
    "simulate": "motion",
    "sweep": "many",
    "fleet": "many",
    "view": "motion",
    "library": "attach",
    "demo": "demo",
}

_INTERRUPTED = 130  # status of a process that Ctrl-C ends, in a shell
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
            _run_command(given)
    except KeyboardInterrupt:
        print(
            "tendon-mj: interrupted; the files written so far are whole, the others are missing",
            file=sys.stderr,
        )
        return _INTERRUPTED
    except (TendonError, OSError, UnicodeError) as error:
        # a recording has a line for each fault; MuJoCo's messages have several lines
        text = str(error)
        text = text if isinstance(error, RecordingError) else "; ".join(text.splitlines())
        print(f"tendon-mj: {text}", file=sys.stderr)
        return 2
    return 0


def _run_command(given: Sequence[str]) -> None:
    if "" in given:
        raise TendonError("an argument is empty, perhaps that of an unset variable of the shell")
    name, *rest = given or [""]
    if given == ["--version"]:
        print(f"tendon-mj {version('tendon-mj')}")
    elif name not in COMMANDS:
        _show_all(given)
    else:
        command = load_command(name)
        try:
            tyro.cli(command, prog=f"tendon-mj {name}", args=rest)
        except SystemExit as end:  # of --help, and of arguments that are refused
            if not end.code:
                print(f"example:\n  {example(command)}")
            raise


def load_command(name: str) -> CommandFunction:
    """The function of a command, each argument of its docstring in one line, which tyro wraps."""
    try:
        module = import_module(f"tendon_mj.cli.{COMMANDS[name]}")
    except ModuleNotFoundError as error:
        raise MissingPackageError.of_lab("the command", error) from None
    command: CommandFunction = getattr(module, name)
    command.__doc__ = _CONTINUED.sub(" ", inspect.getdoc(command) or "")
    return command


def example(command: CommandFunction) -> str:
    """The line below `Example:` in a command's docstring."""
    return (command.__doc__ or "").partition("Example:\n")[2].strip()


def _show_all(given: Sequence[str]) -> None:
    """Print the help of all commands, or refuse an unknown command; loads none."""

    def named(summary: str) -> CommandFunction:
        def command() -> None: ...

        command.__doc__ = summary
        return command

    tyro.extras.subcommand_cli_from_dict(
        {name: named(_help_line(name)) for name in COMMANDS},
        prog="tendon-mj",
        description="Tendon-sheath friction for MuJoCo.",
        args=given,
    )


def _help_line(name: str) -> str:
    """First line of the docstring of a command, from its source."""
    source = resources.files("tendon_mj.cli").joinpath(f"{COMMANDS[name]}.py").read_text("utf-8")
    functions = [node for node in ast.parse(source).body if isinstance(node, ast.FunctionDef)]
    (command,) = (node for node in functions if node.name == name)
    return cast(str, ast.get_docstring(command)).partition("\n")[0]


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
