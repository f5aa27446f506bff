"""Refusals: tested by their class and by facts, such as the place and the value."""

import contextlib

import pytest


@contextlib.contextmanager
def refused(*facts, by=ValueError):
    """The block is refused by an error whose message has each of the facts."""
    with pytest.raises(by) as caught:
        yield
    message = str(caught.value)
    missing = [fact for fact in facts if str(fact) not in message]
    assert not missing, f"{missing} not in {message!r}"
