"""Progress of long work: a callback ``(what, done, total)``."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

_Item = TypeVar("_Item")
Progress = Callable[[str, int, int], None]


def silent(what: str, done: int, total: int) -> None:
    """Ignore progress."""


def counted(progress: Progress, what: str, items: Sequence[_Item]) -> Iterator[_Item]:
    """Each of the items; progress is told before each of them, and after the last."""
    for done, item in enumerate(items):
        progress(what, done, len(items))
        yield item
    progress(what, len(items), len(items))
