"""A refusal is asserted by its class and by facts in its message, not by its sentence."""

from contextlib import contextmanager

import pytest


@contextmanager
def refusing(kind, *facts):
    """Expect an exception of a kind whose message has these facts: a place, a name, a value."""
    with pytest.raises(kind) as refused:
        yield
    missing = [fact for fact in facts if fact not in str(refused.value)]
    assert not missing, f"{missing} not in: {refused.value}"
