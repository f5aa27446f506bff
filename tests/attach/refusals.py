"""A refusal by its class and facts: where, and which value; its sentence may change."""

from contextlib import contextmanager

import pytest

from tendon_mj.errors import TendonError


@contextmanager
def refused(*facts, error=TendonError):
    """Expect an error whose message holds these facts."""
    with pytest.raises(error) as caught:
        yield
    for fact in facts:
        assert fact in str(caught.value)
