"""Suppression of warnings and log files in simulations that may fail, as a search makes many."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

import mujoco

UNSOLVED_WARNING: Final = "some simulations: sheath"  # how the warning of no equilibrium begins


@contextmanager
def suppress_unsolved_warnings() -> Iterator[None]:
    """Ignore the warning of sheaths without equilibrium."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", UNSOLVED_WARNING, RuntimeWarning)
        yield


@contextmanager
def suppress_mujoco_log() -> Iterator[None]:
    """Keep MuJoCo from writing a log file where it runs; a failure shows in the series instead."""
    logger = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(_ignore)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(logger)


def _ignore(message: str) -> None:
    """Drop a message of MuJoCo's."""
