"""A refusal is asserted by its class and by facts in its message, not by its sentence."""

import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

import pytest

from tendon_mj.errors import TendonError


@contextmanager
def refusing(kind: type[Exception] | tuple[type[Exception], ...], *facts: object) -> Iterator[None]:
    """Expect an exception of a kind whose message has these facts; " | " separates several."""
    with pytest.raises(kind) as refused:
        yield
    parts = [part for fact in facts for part in str(fact).split(" | ")]
    missing = [part for part in parts if part not in str(refused.value)]
    assert not missing, f"{missing} not in: {refused.value}"


def refused(call: Callable[[], object]) -> bool:
    """Return whether a call raises an error of the package."""
    with suppress(TendonError):
        call()
        return False
    return True


@contextmanager
def silent(kind: type[Warning] = Warning) -> Iterator[None]:
    """Expect no warning of a kind."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", kind)
        yield
