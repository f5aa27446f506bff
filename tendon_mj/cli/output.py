"""Output of a command: a folder with `result.json` and pictures, and messages on the console."""

from __future__ import annotations

import contextlib
import json
import math
import os
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from fnmatch import fnmatch
from pathlib import Path

import filelock
from matplotlib.figure import Figure
from rich.console import Console
from rich.progress import (
    BarColumn,
    Progress,
    TaskID,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.table import Table

from tendon_mj.errors import InvalidValueError
from tendon_mj.lab.data_check import DataWarning
from tendon_mj.show import DPI
from tendon_mj.whole_file import whole_file


class _Console(Console):
    """Console of a command, which goes on when nobody reads what it prints, as behind `head`."""

    def on_broken_pipe(self) -> None:
        """Print no more."""
        self.quiet = True
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


console = _Console(highlight=False, markup=False, emoji=False)  # names may hold [brackets]

RESULT = "result.json"
LOCK = ".lock"
_SHOWN = (".html", ".png", ".mp4", ".webp")  # what is only looked at: no command reads it


class Output:
    """The folder that a command writes to, and no other run until it is closed or has ended.

    `result.json` is written last. That of an earlier run is removed by `begin`, with the pages and
    pictures that it lists, so that a run that fails leaves none behind.

    Args:
        folder: made if it is not there.
        tables: names of tables that are results too; others may be what this run reads.
        writes: names of files that the command writes and could have been given to read; ``*``
            stands for any text.
        given: files that the command was given to read; None and what is no file are passed over.
        begin: whether `begin` is called at once; else when nothing more can be refused.

    Raises:
        InvalidValueError: it is no folder, a link to none, or cannot be written to; another run is
            writing to it; or a file that was given lies where the command writes, or is a
            result of an earlier run. What is in the folder stays as it was.
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
        self._writes, self._tables = (RESULT, LOCK, *writes), tables
        for path in (folder, *folder.parents):
            if path.exists() and not path.is_dir():
                where = f"--out {folder}" + (f": {path}" if path != folder else "")
                raise InvalidValueError(f"{where} is a file; it must be a folder")
        if folder.is_symlink() and not folder.exists():
            raise InvalidValueError(
                f"--out {folder} is a link to {folder.readlink()}, which is not there; make that"
                " folder, or give another --out"
            )
        for name in (RESULT, *writes):
            path = folder / name
            if path.exists() and not path.is_file():  # a pipe would wait for its writer
                raise InvalidValueError(
                    f"--out {folder}: {name} there is a folder, device or pipe, which no result"
                    " replaces; give another --out"
                )
        self._keep([Path(path) for path in given if path is not None and Path(path).is_file()])
        folder.mkdir(parents=True, exist_ok=True)
        self._lock = filelock.FileLock(folder / LOCK, timeout=0)
        try:
            self._lock.acquire()
        except filelock.Timeout:
            raise InvalidValueError(
                f"--out {folder}: another run is writing there; wait for it, or give another folder"
            ) from None
        except OSError as error:
            raise InvalidValueError(
                f"--out {folder}: nothing can be written there ({error.strerror}); give another"
                " folder"
            ) from None
        if begin:
            self.begin()

    def begin(self) -> None:
        """Remove the result of an earlier run, and the pages, pictures and tables that it lists.

        Recordings and models stay until they are replaced: they may be what this run reads.
        """
        for path in self._earlier():
            path.unlink(missing_ok=True)
        (self.folder / RESULT).unlink(missing_ok=True)

    def _earlier(self) -> list[Path]:
        """Pages, pictures and tables in the folder itself that its result lists."""
        listed: object = []
        result = self.folder / RESULT
        with contextlib.suppress(OSError, ValueError, KeyError, TypeError, RecursionError):
            listed = json.loads(result.read_text(encoding="utf-8"))["files"]  # if it is ours
        names = {n for n in listed if isinstance(n, str)} if isinstance(listed, list) else set()
        return [
            path
            for path in sorted(self.folder.glob("*"))
            if path.name in names
            and (path.suffix in _SHOWN or path.name in self._tables)
            and not path.is_dir()
        ]

    def _keep(self, files: Sequence[Path]) -> None:
        """Refuse to go on if one of the files would be written over or removed."""

        def is_read(path: Path) -> bool:
            return any(path.samefile(file) for file in files)

        for path in sorted(self.folder.glob("*")):
            if any(fnmatch(path.name, one) for one in self._writes) and is_read(path):
                raise InvalidValueError(
                    f"--out {self.folder}: {path.name} there would be written over, and is read by"
                    " this command; give another --out"
                )
        for path in self._earlier():
            if is_read(path):
                raise InvalidValueError(
                    f"--out {self.folder}: {path.name} there would be removed, as {RESULT} lists it"
                    " as a result of an earlier run, and is read by this command; give another"
                    " --out"
                )

    def add(self, path: Path) -> Path:
        """List a file that something else wrote into the folder."""
        self.written.append(path)
        return path

    def figure(self, name: str, figure: Figure) -> Path:
        """Write a figure as ``name``.png."""
        path = self.folder / f"{name}.png"
        with whole_file(path) as made:
            figure.savefig(made, dpi=DPI)
        return self.add(path)

    def result(self, numbers: Mapping[str, object]) -> Path:
        """Write `result.json`: plain numbers in SI units, and the names of the files beside it."""
        path = self.folder / RESULT
        files = sorted({p.relative_to(self.folder).as_posix() for p in self.written})
        text = json.dumps(_plain({**numbers, "files": files}), indent=2, allow_nan=False)
        with whole_file(path) as made:
            made.write_text(text + "\n", encoding="utf-8")
        return self.add(path)

    def close(self, sentence: str = "") -> None:
        """Print the files that were written, and last what came out, in a sentence with units.

        From then on others may write to the folder.
        """
        self._lock.release()
        console.print(f"{time.perf_counter() - self.started:.1f} s; wrote")
        for path in self.written:
            console.print(f"  {path}", soft_wrap=True)
        if sentence:
            console.print(sentence, soft_wrap=True)


def _plain(value: object) -> object:
    """A value for JSON: numbers that JSON does not have become null."""
    if isinstance(value, Mapping):
        return {str(key): _plain(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(inner) for inner in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def print_warnings(warnings: Iterable[DataWarning]) -> None:
    """Print what looks wrong in recordings, a line each."""
    for warning in warnings:
        console.print(f"warning: {warning.sentence}", soft_wrap=True)


def print_table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print a table in which no word is cut; where it does not fit, a paragraph for each row.

    Args:
        head: of the columns.
        rows: cells; the first is the row's name.
    """
    columns = list(zip(head, *rows, strict=True))
    widths = [max(len(word) for cell in column for word in cell.split()) for column in columns]
    left = console.width - sum(widths) - 3 * len(widths) - 1  # of the lines between
    if left >= 0:
        table = Table()
        for width, column in zip(widths, columns, strict=True):
            more = min(left, max(map(len, column)) - width)
            left -= more
            table.add_column(column[0], width=width + more)
        for row in rows:
            table.add_row(*row)
        console.print(table)
        return
    for name, *cells in rows:
        console.print(name, soft_wrap=True)
        for title, cell in zip(head[1:], cells, strict=True):
            console.print(f"  {title}: {cell}", soft_wrap=True)


@contextlib.contextmanager
def progress_bar() -> Iterator[Callable[[str, int, int], None]]:
    """A callback ``(what, done, total)`` that shows a bar for each ``what``."""
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TimeElapsedColumn(),
        TextColumn("elapsed,"),
        TimeRemainingColumn(),
        TextColumn("to go"),
    )
    with Progress(*columns, console=console) as bars:
        tasks: dict[str, TaskID] = {}

        def report(what: str, done: int, total: int) -> None:
            if what not in tasks:
                tasks[what] = bars.add_task(what, total=total, completed=done)  # by an earlier run
            bars.update(tasks[what], completed=done, total=total)

        yield report
