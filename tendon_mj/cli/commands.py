"""The commands, their help, and the exit status of the command line."""

from __future__ import annotations

import ast
import inspect
import re
import shlex
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, redirect_stdout
from functools import partial
from importlib import import_module, resources
from importlib.metadata import version
from io import BytesIO, TextIOWrapper
from pathlib import Path
from typing import cast, get_type_hints

import mujoco
import tyro
from rich.panel import Panel
from rich.table import Table
from rich.text import Text

from tendon_mj.cli.output import console, typed_command
from tendon_mj.errors import (
    INTERRUPTED,
    MissingPackageError,
    RecordingError,
    TendonError,
    UnknownNameError,
)

CommandFunction = Callable[..., object]

_GROUPS = {  # group → name → module, which is loaded when the command is called
    "model": {
        "view": "motion",
        "render": "motion",
        "simulate": "motion",
        "attach": "attach",
        "parameters": "attach",
        "library": "attach",
    },
    "data": {
        "init": "recordings",
        "identify": "identify",
        "check": "recordings",
        "replay": "recordings",
        "diagnose": "diagnose",
        "rehearse": "rehearse",
        "changes": "many",
        "fleet": "many",
    },
    "study": {"sweep": "many", "compare": "bench", "bench": "bench", "demo": "demo"},
}
COMMANDS = {name: module for group in _GROUPS.values() for name, module in group.items()}

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
        return _say_interrupted()
    except (TendonError, OSError, ValueError, mujoco.FatalError) as error:
        if INTERRUPTED in str(error):
            return _say_interrupted()
        if not isinstance(error, TendonError | OSError | UnicodeError):
            raise
        # a recording has a line for each fault; MuJoCo's messages have several lines
        text = str(error)
        text = text if isinstance(error, RecordingError) else "; ".join(text.splitlines())
        print(f"tendon-mj: {text}", file=sys.stderr)
        return 2
    return 0


def _say_interrupted() -> int:
    print(
        "tendon-mj: interrupted; the files written so far are whole, the others are missing",
        file=sys.stderr,
    )
    return _INTERRUPTED


def _run_command(given: Sequence[str]) -> None:
    if "" in given:
        raise TendonError("an argument is empty, perhaps that of an unset variable of the shell")
    name, *rest = given or [""]
    if given == ["--version"]:
        print(f"tendon-mj {version('tendon-mj')}")
    elif name in ("", "-h", "--help"):
        _show_all()
    elif name not in COMMANDS:
        if Path(name).exists():
            meant = {".xml": "view", "": "fleet"}.get(Path(name).suffix, "check")
            raise TendonError(f"{name} is no command; did you mean tendon-mj {meant} {name}?")
        raise UnknownNameError("command", name, COMMANDS)
    else:
        command = load_command(name)
        config = (tyro.conf.DisallowNone,)  # the default of options, which cannot be given
        call = partial(tyro.cli, command, prog=f"tendon-mj {name}", args=rest, config=config)
        if {"-h", "--help"} & set(rest):
            _show_help(command, call)
        else:
            call()


def _show_help(command: CommandFunction, call: Callable[[], object]) -> None:
    """Print tyro's help, of which it does not wrap the description, and an example."""
    shown = TextIOWrapper(BytesIO(), sys.stdout.encoding, "backslashreplace", write_through=True)
    shown.isatty = sys.stdout.isatty  # type: ignore[method-assign]  # keeps its colours
    try:
        with redirect_stdout(shown):
            call()
    finally:
        shown.seek(0)
        for line in shown.read().splitlines():
            console.print(Text.from_ansi(line), soft_wrap=False)
        print(f"example:\n  {example(command)}")


def load_command(name: str) -> CommandFunction:
    """The function of a command, each argument of its docstring in one line, which tyro wraps."""
    try:
        module = import_module(f"tendon_mj.cli.{COMMANDS[name]}")
        options = import_module("tendon_mj.cli.options")
    except ModuleNotFoundError as error:
        raise MissingPackageError.of_lab("the command", error) from None
    command: CommandFunction = getattr(module, name)
    command.__doc__ = _CONTINUED.sub(" ", inspect.getdoc(command) or "")
    hints = get_type_hints(command, include_extras=True)
    arguments = inspect.signature(command).parameters.values()
    command.__annotations__ = {a.name: options.described(a, hints[a.name]) for a in arguments}
    return command


def example(command: CommandFunction) -> str:
    """The line below `Example:` in a command's docstring."""
    return (command.__doc__ or "").partition("Example:\n")[2].strip()


def _show_all() -> None:
    """Print the help of all commands, in groups; loads none."""
    print("usage: tendon-mj COMMAND [OPTIONS]\n       tendon-mj COMMAND --help\n")
    print("Tendon-sheath friction for MuJoCo.")
    for group, names in _GROUPS.items():
        table = Table.grid("", "", padding=(0, 2, 0, 0))
        for name in names:
            table.add_row(name, _help_line(name))
        console.print(Panel(table, title=group, title_align="left"), soft_wrap=False)


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
