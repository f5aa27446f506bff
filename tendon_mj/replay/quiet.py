"""What simulations at values that are only tried keep to themselves."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

import mujoco

UNSOLVED: Final = "some simulations: sheath"  # how the warning of no equilibrium begins


@contextmanager
def trials() -> Iterator[None]:
    """Keep quiet about sheaths without equilibrium."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", UNSOLVED, RuntimeWarning)
        yield


@contextmanager
def unlogged() -> Iterator[None]:
    """Keep MuJoCo from writing a log file where it runs, for simulations that may fail."""
    logger = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(_ignore)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(logger)


def _ignore(message: str) -> None:
    """Failing shows in the series."""
