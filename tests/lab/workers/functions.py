"""Functions that tests send to workers, and a store that counts what it is given."""

import os
import signal
import time
from pathlib import Path

import numpy as np

from tendon_mj.errors import InvalidValueError

KEYS = [f"task_{k:02d}" for k in range(12)]


def number(key):
    return int(key.rpartition("_")[2])


class Kept:
    """Results in memory; ``written`` has a key as often as it was written."""

    def __init__(self, done=()):
        self.results, self.written, self._done = {}, [], set(done)

    def done(self):
        return self._done | self.results.keys()

    def write(self, key, result):
        self.written.append(key)
        self.results[key] = result


def scaled(factor, number):
    return factor * number


def logged(folder, number):
    """Write to a file that a task was completed."""
    time.sleep(0.01)
    with Path(folder, "log").open("a") as log:
        log.write(f"{number}\n")
    return number


def row(folder, number):
    """A table of one row, after a moment."""
    logged(folder, number)
    time.sleep(0.05)
    return {"k": np.array([number])}


def mortal(folder, number):
    """Kill the worker in the first attempt at task 3."""
    mark = Path(folder, "killed")
    if number == 3 and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return logged(folder, number)


def doomed(_, number):
    os.kill(os.getpid(), signal.SIGKILL)


def refused(_, number):
    raise InvalidValueError(f"{number} is too much")


def threads(_, number):
    return os.environ["OMP_NUM_THREADS"]
