"""Functions that tests send to workers, and a store that counts what it is given."""

import os
import signal
import time
from multiprocessing.connection import Connection
from pathlib import Path

from tendon_mj.errors import InvalidValueError

PIPE_BUF = 4096  # bytes that Linux writes to a pipe at once


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
    """Say in a file that a task was completed."""
    time.sleep(0.01)
    with Path(folder, "log").open("a") as log:
        log.write(f"{number}\n")
    return number


def mortal(folder, number):
    """Kill the worker in the first attempt at task 3."""
    mark = Path(folder, "killed")
    if number == 3 and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return logged(folder, number)


def killed_while_it_answers(folder, number):
    """Give much, and kill the worker halfway through any message that a pipe may take in parts."""
    send, mark = Connection._send, Path(folder, "killed")

    def send_half(self, content, *rest):
        if len(content) > PIPE_BUF and not mark.exists():
            mark.touch()
            send(self, content[: len(content) // 2], *rest)
            os.kill(os.getpid(), signal.SIGKILL)
        send(self, content, *rest)

    Connection._send = send_half
    return bytes(1_000_000 + number)


def doomed(_, number):
    os.kill(os.getpid(), signal.SIGKILL)


def refused(_, number):
    raise InvalidValueError(f"{number} is too much")


def threads(_, number):
    return os.environ["OMP_NUM_THREADS"]
