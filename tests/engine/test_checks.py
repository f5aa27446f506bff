"""What becomes of a check in Python while MuJoCo compiles a model."""

import sys

import pytest

from tendon_mj.engine.sheath_plugin.validation import sheath as validate
from tests.engine.test_refusals import LAW, compiled, instance


def test_an_interruption_while_a_model_is_compiled_refuses_it(monkeypatch):
    """Python cannot raise in a callback of C, whose answer is then left to chance."""
    lost = []

    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(sys, "unraisablehook", lambda args: lost.append(args.exc_type))
    monkeypatch.setattr(validate, "_check_instance", interrupted)
    with pytest.raises(ValueError, match="interrupted while the model was compiled"):
        compiled(instance("s", **LAW))
    assert lost == [KeyboardInterrupt]


@pytest.mark.parametrize("name", ["%s%n", "é" * 3000, "%" * 3000])
def test_a_message_arrives_whatever_is_in_it(name):
    with pytest.raises(ValueError, match="engine error") as refused:
        compiled(instance(name, **(LAW | {"tendon": "none"})))
    assert f"instance '{name[:100]}" in str(refused.value)
