"""What becomes of a check in Python while MuJoCo compiles a model."""

import ctypes
import gc
import sys

import mujoco
import pytest

from tendon_mj.plugin.sheath_plugin import validate
from tests.plugin.test_refusals import LAW, compiled, instance
from tests.plugin.test_servo_refusals import compiled as servo


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


def test_a_mistake_in_a_sheath_is_told_before_what_follows_from_it_in_a_servo():
    servo_of = instance("v", tendon="flexor", tension_gain="7", velocity_gain="2")
    servos = f'</plugin><plugin plugin="tendon_mj.servo">{servo_of}</plugin>'
    pull = '<plugin plugin="tendon_mj.servo" instance="v" joint="knuckle"/>'
    spool = {"reel_joint": "knukle", "reel_radius": "0.01"}
    with pytest.raises(ValueError, match="sheath instance 's': reel_joint: unknown joint 'knukle'"):
        compiled(
            servos + '<plugin plugin="tendon_mj.sheath">' + instance("s", **LAW, **spool),
            actuators=pull,
        )


class _Heap(ctypes.Structure):
    """`struct mallinfo2` of glibc: ten numbers."""

    _fields_ = (("numbers", ctypes.c_size_t * 10),)


def _allocated():
    """Bytes that the process holds: mapped by themselves, and in use on the heap."""
    mallinfo2 = ctypes.CDLL(None).mallinfo2
    mallinfo2.restype = _Heap
    gc.collect()
    numbers = mallinfo2().numbers
    return numbers[4] + numbers[7]


# The first and last instance of a model are MuJoCo's own: one has begun when ours is refused.
_PID = """</plugin><plugin plugin="mujoco.pid"><instance name="p"><config key="kp" value="1"/>
  </instance></plugin><plugin plugin="tendon_mj.sheath">"""
_DRIVEN = """<plugin plugin="mujoco.pid" instance="p" joint="knuckle"/>
  <plugin plugin="mujoco.pid" joint="knuckle"><config key="kp" value="1"/></plugin>"""


def _spoiled():
    """A model whose tendon, once compiled, is given what its sheath cannot be on."""
    model = compiled(instance("s", **LAW, reel_joint="knuckle", reel_radius="0.01"))
    model.tendon_stiffness[0] = 5.0
    return model


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="only glibc tells what it holds")
@pytest.mark.parametrize(
    "refused",
    [
        lambda: compiled(instance("bad", **(LAW | {"friction": "-1"}))),
        lambda: compiled(
            instance("good", **LAW),
            instance("bad", **(LAW | {"tendon": "extensor", "guides": "x"})),
        ),
        lambda: compiled(instance("bad", **(LAW | {"tendon": "forked", "pretension": "1"}))),
        lambda: compiled(_PID, instance("bad", **(LAW | {"tendon": "forked"})), actuators=_DRIVEN),
        lambda: servo(tension_gain="-1"),
        lambda: servo(target='site="a"'),
        lambda: mujoco.MjData(_spoiled()),
    ],
    ids=["configuration", "second", "tendon", "beside MuJoCo's", "servo", "joint", "data"],
)
def test_a_refusal_leaves_nothing_behind(refused):
    def grown():
        before = _allocated()
        for _ in range(50):
            with pytest.raises((ValueError, mujoco.FatalError), match="plugin tendon_mj"):
                refused()
        return _allocated() - before

    assert min(grown() for _ in range(3)) < 50 * 16  # other things are kept once
