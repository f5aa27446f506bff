"""What MuJoCo Warp cannot simulate is refused by name, with what to do instead."""

import mujoco
import pytest

from tendon_mj.errors import NoPluginsError
from tests.engine import servos
from tests.engine.test_driven import arm
from tests.warp.models import fingers, tw

MOTOR = '<motor tendon="t" ctrlrange="-20 0"/>'
PULLEY = '<site site="a"/><site site="b"/><pulley divisor="2"/><site site="c"/><site site="d"/>'


def reel(**law):
    return fingers(kinds=("reel",), **law)


def disabled(model):
    """The model without passive forces."""
    flags = mujoco.mjtDisableBit
    model.opt.disableflags |= flags.mjDSBL_SPRING.value | flags.mjDSBL_DAMPER.value
    return model


REFUSED = {
    "servo 'servo'": servos.model,
    "integrator RK4": lambda: fingers(kinds=("reel",), integrator="RK4"),
    "sheath 'reel': viscous_friction = 2 ": lambda: reel(viscous_friction=2.0),
    "sheath 'reel': creep = 0.1 ": lambda: reel(creep=0.1, creep_time=1.0),
    "sheath 'reel': backlash": lambda: reel(backlash=1e-3),
    "sheath 'reel': axial_damping": lambda: reel(axial_damping=1.0),
    "sheath 's': a tendon that branches at a pulley": lambda: arm(MOTOR, 0.1, path=PULLEY),
    "actuatorfrcrange": lambda: arm(
        MOTOR, 0.1, 'actuatorfrcrange="-5 0" actuatorfrclimited="true"'
    ),
    "polynomial stiffness": lambda: arm(MOTOR, 0.1, 'stiffness="60 5 5"'),
    "springs and dampers both": lambda: disabled(reel()),
}


@pytest.mark.parametrize("what", REFUSED)
def test_it_is_refused_by_name(what):
    with pytest.raises(NoPluginsError, match=what) as refusal:
        tw.put_model(REFUSED[what]())
    assert "mujoco.rollout" in str(refusal.value)


def test_a_model_without_sheaths_goes_as_it_is():
    m = tw.put_model(mujoco.MjModel.from_xml_string("<mujoco/>"))
    assert m.callback.passive is None
