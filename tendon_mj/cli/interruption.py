"""Ctrl-C: one `KeyboardInterrupt`, raised again where Python could not raise it.

In a finaliser and in a callback of C Python prints an exception and goes on, so that a Ctrl-C which
arrives there would be lost.
"""

from __future__ import annotations

import _thread
import contextlib
import signal
import sys
import threading
from collections.abc import Iterator

_AGAIN = 0.01  # after which it is raised again [s]

_pressed = False


def pressed() -> bool:
    """Whether Ctrl-C was pressed in the last, or the present, `interruptible`."""
    return _pressed


@contextlib.contextmanager
def interruptible() -> Iterator[None]:
    """Inside, the first Ctrl-C interrupts wherever it arrives, and later ones do nothing.

    They would cut off the way out, and go on doing nothing behind it. Nothing is changed where the
    process has its own way with Ctrl-C.
    """
    global _pressed
    _pressed = False
    if signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield
        return
    before, timers = sys.unraisablehook, list[threading.Timer]()

    def raise_later(lost: sys.UnraisableHookArgs) -> None:
        if not (_pressed and issubclass(lost.exc_type, KeyboardInterrupt)):
            before(lost)
            return
        signal.signal(signal.SIGINT, _press)
        timers.append(threading.Timer(_AGAIN, _thread.interrupt_main))
        timers[-1].daemon = True
        timers[-1].start()

    signal.signal(signal.SIGINT, _press)
    sys.unraisablehook = raise_later
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.SIG_IGN if _pressed else signal.default_int_handler)
        sys.unraisablehook = before
        for timer in timers:
            timer.cancel()


def _press(number: int, frame: object) -> None:
    global _pressed
    _pressed = True
    signal.signal(number, signal.SIG_IGN)
    raise KeyboardInterrupt
