"""Keeps a simulation at the pace of the clock, frame by frame."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from tendon_mj.show.live.simulation import LiveSimulation

FPS = 60.0  # [1/s]
_LAG = 0.5  # that is caught up; beyond it the simulation is slower than the clock [s]
_LONGEST = 0.1  # between two frames in any case [s]


@dataclass(frozen=True)
class RealTime:
    """How well a simulation kept the pace.

    Attributes:
        simulated: [s].
        elapsed: on the clock, without pauses [s].
        frames: that were shown.
    """

    simulated: float
    elapsed: float
    frames: int

    @property
    def factor(self) -> float:
        """Simulated time over that of the clock [-]."""
        return self.simulated / self.elapsed if self.elapsed > 0.0 else 0.0

    def sentence(self) -> str:
        """What came out, in a sentence."""
        return (
            f"simulated {self.simulated:.1f} s in {self.elapsed:.1f} s, {self.factor:.2f} × real "
            f"time, at {self.frames / max(self.elapsed, 1e-9):.0f} frames a second"
        )


def run_in_real_time(
    simulation: LiveSimulation, show: Callable[[], bool], seconds: float | None = None
) -> RealTime:
    """Simulate and show by turns, until there is nobody to watch or the time is up.

    Ctrl-C ends it as closing the window does, after the frame at hand: an interruption within one
    may be lost in a callback of the viewer, or leave a lock behind.

    Args:
        simulation: is advanced.
        show: shows it, and says whether it is still watched.
        seconds: after which to end [s]; None: never.

    Raises:
        TendonError: the simulation became unstable.
    """
    simulated, elapsed, owed, frames = 0.0, 0.0, 0.0, 0
    with _interruption() as interrupted:
        watched = show()  # the first time a window or a page opens, which is no part of the pace
        last = time.perf_counter()
        while watched and not interrupted() and (seconds is None or elapsed < seconds):
            rest = last + 1.0 / FPS - time.perf_counter()
            if rest > 0.0:
                time.sleep(rest)
            now = time.perf_counter()
            passed, last = now - last, now
            if not simulation.paused:
                elapsed += passed
                owed = min(owed + passed, _LAG)
                done = simulation.advance(owed, limit=_LONGEST)
                simulated, owed = simulated + done, owed - done
            watched = show()
            frames += 1
    return RealTime(simulated, elapsed, frames)


@contextmanager
def _interruption() -> Iterator[Callable[[], bool]]:
    """Whether Ctrl-C was pressed; a second one interrupts at once.

    Only the main thread is told of signals; in others, nothing is changed.
    """
    pressed = threading.Event()

    def press(number: int, frame: object) -> None:
        if pressed.is_set():
            raise KeyboardInterrupt
        pressed.set()

    if threading.current_thread() is not threading.main_thread():
        yield pressed.is_set
        return
    before = signal.signal(signal.SIGINT, press)
    try:
        yield pressed.is_set
    finally:
        signal.signal(signal.SIGINT, before or signal.SIG_DFL)
