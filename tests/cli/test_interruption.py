"""Ctrl-C interrupts once, wherever it arrives."""

import signal
import sys
import time

import pytest

from tendon_mj.cli import interruptible
from tendon_mj.cli.interruption import pressed

PATIENCE = 10.0  # [s]


class InterruptedAsItEnds:
    """Ctrl-C arrives in its finaliser, in which Python can raise nothing."""

    def __del__(self):
        signal.raise_signal(signal.SIGINT)


@pytest.fixture(autouse=True)
def _as_a_process_begins():
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def wait():
    deadline = time.monotonic() + PATIENCE
    while time.monotonic() < deadline:
        time.sleep(1e-3)
    pytest.fail("nothing was interrupted")


def test_the_first_interrupts_and_the_others_do_not_cut_off_its_way_out():
    with pytest.raises(KeyboardInterrupt), interruptible():  # noqa: PT012
        try:
            signal.raise_signal(signal.SIGINT)
        finally:
            signal.raise_signal(signal.SIGINT)
            ended = True
    assert ended
    assert pressed()


def test_one_that_is_lost_in_a_finaliser_is_raised_again():
    hook = sys.unraisablehook
    with pytest.raises(KeyboardInterrupt), interruptible():  # noqa: PT012
        gone = InterruptedAsItEnds()
        del gone
        wait()
    assert sys.unraisablehook is hook


def test_one_that_is_lost_at_the_very_end_interrupts_nothing_later():
    with interruptible():
        gone = InterruptedAsItEnds()
        del gone
    assert pressed()
    signal.signal(signal.SIGINT, signal.default_int_handler)
    time.sleep(0.05)


def test_other_exceptions_are_told_as_ever(monkeypatch):
    told = []
    monkeypatch.setattr(sys, "unraisablehook", told.append)

    class Fails:
        def __del__(self):
            raise RuntimeError

    with interruptible():
        gone = Fails()
        del gone
    assert [lost.exc_type for lost in told] == [RuntimeError]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    assert not pressed()


def test_a_process_that_has_its_own_way_with_ctrl_c_keeps_it():
    came = []
    signal.signal(signal.SIGINT, lambda *_: came.append(1))
    with interruptible():
        signal.raise_signal(signal.SIGINT)
    assert came
    assert not pressed()
