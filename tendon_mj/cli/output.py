"""Output of a command: a folder with `result.json` and pictures, and messages on the console."""

from __future__ import annotations

import contextlib
import json
import math
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextvars import ContextVar
from fnmatch import fnmatch
from pathlib import Path
from typing import TYPE_CHECKING

import filelock
from rich.console import Console
from rich.progress import Progress, TaskID
from rich.table import Table

from tendon_mj.errors import InvalidValueError
from tendon_mj.whole_file import whole_file

if TYPE_CHECKING:  # the help of a command needs neither
    from matplotlib.figure import Figure

    from tendon_mj.lab.data_check import DataWarning


typed_command = ContextVar("typed_command", default="")  # for the provenance of a result
console = Console(soft_wrap=True, highlight=False, markup=False, emoji=False)

RESULT = "result.json"
LOCK = ".lock"
_VIEWED = (".html", ".png", ".mp4", ".webp")  # never read by a command


class Output:
    """The folder that a command writes to, locked against other runs until it is closed.

    `result.json` is written last. That of an earlier run is removed by `begin`, at once or when
    nothing more can be refused, with the pages, pictures and ``tables`` that it lists, so that a
    run that fails leaves none behind. A command that would overwrite a file that it was ``given``
    is refused; ``writes`` are the names, with ``*``, of files that it writes besides.
    """

    def __init__(
        self,
        folder: Path,
        tables: Sequence[str] = (),
        *,
        writes: Sequence[str] = (),
        given: Iterable[str | Path | None] = (),
        begin: bool = True,
    ) -> None:
        self.folder = folder
        self.written: list[Path] = []
        self.started = time.perf_counter()
        self._tables = tables
        _check_given(folder, (RESULT, *writes), given)
        self._lock = filelock.FileLock(folder / LOCK, timeout=0)
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._lock.acquire()
        except filelock.Timeout:
            raise InvalidValueError(
                f"--out {folder}: another run is writing there; wait for it, or give another folder"
            ) from None
        except OSError as error:
            raise InvalidValueError(
                f"--out {folder}: not a folder to write to ({error.strerror}); give another one"
            ) from None
        if begin:
            self.begin()

    def begin(self) -> None:
        """Remove the result of an earlier run, and the pages, pictures and tables that it lists.

        Recordings and models stay until they are replaced: this run may read them.
        """
        result, listed = self.folder / RESULT, set[str]()
        with contextlib.suppress(OSError, ValueError, KeyError, TypeError):
            listed = set(map(str, json.loads(result.read_text(encoding="utf-8"))["files"]))
        for path in [p for p in self.folder.iterdir() if p.name in listed and p.is_file()]:
            if path.suffix in _VIEWED or path.name in self._tables:
                path.unlink()
        result.unlink(missing_ok=True)

    def add(self, path: Path) -> Path:
        """List a file that something else wrote into the folder."""
        self.written.append(path)
        return path

    def figure(self, name: str, figure: Figure) -> Path:
        """Write a figure as ``name``.png."""
        path = self.folder / f"{name}.png"
        with whole_file(path) as made:
            figure.savefig(made)
        return self.add(path)

    def result(self, numbers: Mapping[str, object]) -> Path:
        """Write `result.json`: plain numbers in SI units, and the names of the files next to it."""
        path = self.folder / RESULT
        files = sorted({p.relative_to(self.folder).as_posix() for p in self.written})
        text = json.dumps(_for_json({**numbers, "files": files}), indent=2, allow_nan=False)
        with whole_file(path) as made:
            made.write_text(text + "\n", encoding="utf-8")
        return self.add(path)

    def close(self, sentence: str = "") -> None:
        """Print the files, and last the result in a sentence with units; unlock the folder."""
        self._lock.release()
        console.print(f"{time.perf_counter() - self.started:.1f} s; wrote")
        for path in self.written:
            console.print(f"  {path}")
        if sentence:
            console.print(sentence)

    def finish(self, numbers: dict[str, object], sentence: str) -> dict[str, object]:
        """Write `result.json`, then `close`; returns the numbers."""
        self.result(numbers)
        self.close(sentence)
        return numbers


def _check_given(folder: Path, writes: Sequence[str], given: Iterable[str | Path | None]) -> None:
    """Refuse to overwrite a file that the command was given."""
    files = [Path(path) for path in given if path is not None and Path(path).is_file()]
    for path in sorted(folder.glob("*")) if files else ():
        is_written = any(fnmatch(path.name, name) for name in writes)
        if is_written and any(path.exists() and path.samefile(file) for file in files):
            raise InvalidValueError(
                f"--out {folder}: {path.name} there is read by this command, and would be"
                " overwritten; give another --out"
            )


def _for_json(value: object) -> object:
    """A value for JSON, in which NaN and infinities are null."""
    if isinstance(value, Mapping):
        return {str(key): _for_json(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_for_json(inner) for inner in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def print_warnings(warnings: Iterable[DataWarning]) -> None:
    """Print warnings about recordings, a line each."""
    for warning in warnings:
        console.print(f"warning: {warning.sentence}")


def print_table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print a table in which no word is cut; if it does not fit, a paragraph for each row.

    The first cell of a row is its name.
    """
    columns = list(zip(head, *rows, strict=True))
    widths = [max(len(word) for cell in column for word in cell.split()) for column in columns]
    left = console.width - sum(widths) - 3 * len(widths) - 1  # beside the lines between
    if left >= 0:
        table = Table()
        for title, width, column in zip(head, widths, columns, strict=True):
            more = min(left, max(map(len, column)) - width)
            table.add_column(title, width=width + more)
            left -= more
        for row in rows:
            table.add_row(*row)
        console.print(table, soft_wrap=False)
        return
    for name, *cells in rows:
        console.print(name)
        for title, cell in zip(head[1:], cells, strict=True):
            console.print(f"  {title}: {cell}")


@contextlib.contextmanager
def progress_bar() -> Iterator[Callable[[str, int, int], None]]:
    """A callback ``(what, done, total)`` that shows a bar for each ``what``."""
    with Progress(console=console) as bars:
        tasks: dict[str, TaskID] = {}

        def report(what: str, done: int, total: int) -> None:
            if what not in tasks:
                tasks[what] = bars.add_task(what, total=total, completed=done)  # by an earlier run
            bars.update(tasks[what], completed=done, total=total)

        yield report
