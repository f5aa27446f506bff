"""Messages of checks in Python while MuJoCo compiles a model."""

import mujoco
import pytest

from tests.plugin.rigs import refused
from tests.plugin.test_refusals import LAW, compiled, instance


@pytest.mark.parametrize("name", ["%s%n", "é" * 3000, "%" * 3000])
def test_a_message_arrives_whatever_is_in_it(name):
    with refused(f"instance '{name[:100]}"):
        compiled(instance(name, **(LAW | {"tendon": "none"})))


def test_a_mistake_in_a_sheath_is_told_before_what_follows_from_it_in_a_servo():
    servo_of = instance("v", tendon="flexor", tension_gain="7", velocity_gain="2")
    servos = f'</plugin><plugin plugin="tendon_mj.servo">{servo_of}</plugin>'
    pull = '<plugin plugin="tendon_mj.servo" instance="v" joint="knuckle"/>'
    spool = {"reel_joint": "knukle", "reel_radius": "0.01"}
    with refused("sheath instance 's': reel_joint", "'knukle'"):
        compiled(
            servos + '<plugin plugin="tendon_mj.sheath">' + instance("s", **LAW, **spool),
            actuators=pull,
        )


def test_data_of_a_model_that_has_become_unsuited_is_refused():
    model = compiled(instance("s", **LAW, reel_joint="knuckle", reel_radius="0.01"))
    model.tendon_stiffness[0] = 5.0
    with refused("plugin tendon_mj.sheath instance 's'", "5 0 0", by=mujoco.FatalError):
        mujoco.MjData(model)
