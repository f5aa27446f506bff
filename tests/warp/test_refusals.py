"""Models that MuJoCo Warp cannot simulate are refused by name, with a remedy."""

import mujoco
import pytest

from tendon_mj import Parameters, add_cable_drive, add_friction
from tendon_mj.errors import InvalidValueError, NoPluginsError
from tests import rigs
from tests.plugin.test_driven import arm
from tests.plugin.test_play import arm as pulleys
from tests.refusals import refusing
from tests.warp.models import fingers, fingers_xml, mjw, tw

wp = pytest.importorskip("warp")

MOTOR = '<motor tendon="t" ctrlrange="-20 0"/>'
PULLEY = "a b /2 c d"


def reel(**law):
    return fingers(kinds=("reel",), **law)


def disabled(model):
    """The model without passive forces."""
    flags = mujoco.mjtDisableBit
    model.opt.disableflags |= flags.mjDSBL_SPRING.value | flags.mjDSBL_DAMPER.value
    return model


def late():
    """A model in which a sensor shows the force of a while ago."""
    text = fingers_xml(kinds=("reel",))
    if "reel_force" not in text:
        pytest.skip("MuJoCo Warp before 3.14 takes no sensors of force")
    spec = mujoco.MjSpec.from_string(text)
    spec.sensor("reel_force").nsample, spec.sensor("reel_force").delay = 5, 0.002
    return spec.compile()


def turned():
    """A model whose joint a cable turns that is not drawn."""
    spec = mujoco.MjSpec.from_string(rigs.lever('<motor name="m" joint="j"/>'))
    return add_cable_drive(spec, "m", radius=0.01, bend=3.0, friction=0.1).compile()


def curved():
    """A cable of stated stiffness, whose own spring is curved."""
    spec = mujoco.MjSpec.from_string(fingers_xml(kinds=("cable",), axial_stiffness=200.0))
    spec.tendon("cable").stiffness = [400, 50, 0]
    return spec.compile()


def without_sensors(model):
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_SENSOR.value
    return model


def without_actuation(model):
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_ACTUATION.value
    return model


REFUSED = {
    "sensor 'reel_force' with a history": late,
    "sheath 'cable': a polynomial stiffness": curved,
    "disabling sensors where a constraint": lambda: without_sensors(fingers(kinds=("limit",))),
    "servo 'servo'": rigs.servo_model,
    "sheath 'j_cable_sheath': a cable drive": turned,
    "integrator RK4": lambda: fingers(kinds=("reel",), integrator="RK4"),
    "sheath 'reel': viscous_friction = 2 ": lambda: reel(viscous_friction=2.0),
    "sheath 'reel': creep = 0.1 ": lambda: reel(creep=0.1, creep_time=1.0),
    "sheath 'reel': direction_asymmetry": lambda: reel(direction_asymmetry=0.1),
    "sheath 'reel': axial_damping": lambda: reel(axial_damping=1.0),
    "sheath 'one_sheath': output_play = 0.1": lambda: pulleys(output_play=0.1)[0],
    "sheath 'one_sheath': reel_play = 0.1": lambda: pulleys(reel_play=0.1)[0],
    "sheath 's': an elastic tendon that branches at a pulley": lambda: arm(
        MOTOR, 0.1, path=PULLEY, axial_stiffness=1e4
    ),
    "polynomial stiffness": lambda: arm(MOTOR, 0.1, 'stiffness="60 5 5"'),
    "springs and dampers both": lambda: disabled(reel()),
}


@pytest.mark.parametrize("what", REFUSED)
def test_it_is_refused_by_name(what):
    with pytest.raises(NoPluginsError, match=what) as refusal:
        tw.put_model(REFUSED[what]())
    assert "mujoco.rollout" in str(refusal.value)


@pytest.mark.parametrize("sensors", [(), ("input_tension",)])
def test_mujoco_warp_itself_refuses_the_sensor_that_every_sheath_has(sensors):
    spec = mujoco.MjSpec.from_string(rigs.pulled_xml())
    model = add_friction(spec, "t", friction=0.1, sensors=sensors).compile()
    for refused in (model, rigs.servo_model()):
        with refusing(NotImplementedError, "mjSENS_PLUGIN"):
            mjw.put_model(refused)


def test_a_model_without_sheaths_goes_as_it_is():
    m = tw.put_model(mujoco.MjModel.from_xml_string("<mujoco/>"))
    assert m.callback.passive is None


@pytest.mark.parametrize("effect", ["direction_asymmetry", "axial_damping", "viscous_friction"])
def test_so_is_a_live_parameter(effect):
    model = reel()
    data = mujoco.MjData(model)
    Parameters(model, data)[f"reel.{effect}"] = 0.5
    with pytest.raises(NoPluginsError, match=f"sheath 'reel': {effect} = 0.5 "):
        tw.put_data(model, data)


def drum():
    return fingers(kinds=("drum",))


def history_of_forces(m):
    m.opt.run_rne_postconstraint = True
    without_sensors(m)


@pytest.mark.parametrize(
    ("make", "change", "kind", "said"),
    [
        (drum, lambda m: setattr(m.opt, "integrator", 1), NoPluginsError, "integrator RK4"),
        (drum, history_of_forces, NoPluginsError, "run_rne_postconstraint without sensors"),
        (drum, without_actuation, InvalidValueError, "flag actuation"),
        *(
            (make, disabled, NoPluginsError, "springs and dampers both")
            for make in (reel, drum, lambda: arm(MOTOR, 0.1))
        ),
    ],
)
def test_so_are_options_that_are_set_on_the_device(make, change, kind, said):
    model = make()
    m, d = tw.put_model(model), tw.make_data(model)
    change(m)
    with refusing(kind, said):
        mjw.forward(m, d)


@pytest.mark.parametrize(
    ("worlds", "kind"), [([1, 0, 1], wp.int32), ([True, False], wp.bool), ([[True] * 3], wp.bool)]
)
def test_worlds_to_reset_are_one_bool_each(worlds, kind):
    model = reel()
    m, d = tw.put_model(model), tw.make_data(model, 3)
    mjw.step(m, d)
    with refusing(InvalidValueError, "reset must be a Warp array of 3 bool"):
        tw.reset_data(m, d, wp.array(worlds, dtype=kind))
    assert (d.time.numpy() > 0.0).all()
    with refusing(InvalidValueError, "reset must be a Warp array of 3 bool"):
        tw.reset_data(m, d, [True, False, True])
    with refusing(InvalidValueError, "world_id = 1.0 must be a whole number"):
        tw.get_data_into(mujoco.MjData(model), model, d, 1.0)
