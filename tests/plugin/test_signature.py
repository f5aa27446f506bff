"""Signatures of a state: alike for models that say the same, of another number for all others."""

import mujoco
import numpy as np
import pytest

from tendon_mj import add_friction, add_sites, add_tendon
from tendon_mj.plugin import read_layout
from tendon_mj.plugin.sheath_plugin import signature as sg
from tendon_mj.plugin.sheath_plugin.state import STATE

LAYOUT = read_layout()


def rig(tendons=("one", "two"), friction=0.1, **more):
    spec = mujoco.MjSpec()
    sites = add_sites(spec, "site", [[0, 0, 0], [1, 0, 0], [1, 1, 0]])
    for name in ("near", "far"):
        body = spec.worldbody.add_body(name=name)
        body.add_geom(size=[0.1, 0, 0])
        body.add_joint(name=name)
    for name in tendons:
        add_tendon(spec, name, sites)
    law = {"axial_stiffness": 1e3, "pretension": 1.0, "sensors": ()}
    add_friction(spec, "one", friction=friction, name="sheath", **law, **more)
    return spec.compile()


def configured(model):
    return sg.config_signature(LAYOUT, model._address, 0)


def bound(model, tendon=0.0, joints=(-1.0, -1.0), actuator=-1.0, sensors=(0.0, -1.0)):
    state = np.zeros(model.npluginstate * 8, np.uint8)
    fields = state[: STATE.itemsize].view(STATE)
    fields["tendon"], fields["reel_actuator"] = tendon, actuator
    fields["reel_joint"], fields["output_joint"] = joints
    fields["first_sensor"], fields["last_sensor"] = sensors
    fields["first_actuator"] = fields["last_actuator"] = -1.0
    return sg.binding_signature(LAYOUT, model._address, 0, state.ctypes.data)


def test_models_that_say_the_same_have_the_same():
    for read in (configured, bound):
        numbers = {read(model) for model in (rig(), rig())}
        assert len(numbers) == 1
        (number,) = numbers
        assert number >= 1.0
        assert number == int(number)


def test_every_change_of_the_configuration_is_seen():
    changes = [{"friction": mu} for mu in np.linspace(0.1, 0.9, 81).round(2)]
    changes += [{"axial_damping": 1.0}, {"backlash": 1.0}, {"tendon_mass": 1.0}]
    changes += [{"reel_joint": j, "reel_radius": 0.1} for j in ("near", "far")]
    numbers = [configured(rig(**change)) for change in changes]
    assert len(set(numbers)) == len(changes)


def test_every_other_element_under_an_index_is_seen():
    model = rig(reel="reel")
    spools = {
        joints: bound(model, joints=joints) for joints in ((-1.0, -1.0), (0.0, -1.0), (-1.0, 0.0),
                                                           (1.0, -1.0), (0.0, 1.0), (1.0, 0.0))
    }  # fmt: skip
    assert len(set(spools.values())) == len(spools)
    assert bound(rig(), 0.0) != bound(rig(), 1.0)
    assert bound(rig(("one", "two"))) != bound(rig(("two", "one")))  # sizes and names are the same
    assert bound(rig()) != bound(rig(("one", "two", "three")))


@pytest.mark.parametrize("index", [-2.0, 2.0, 1e300, np.nan, np.inf, -np.inf, -0.5])
def test_an_index_that_the_model_has_not_is_none(index):
    model = rig()
    assert bound(model, index) == sg.NONE
    assert bound(model, joints=(index, -1.0)) == sg.NONE
    assert bound(model, joints=(-1.0, index)) == sg.NONE
    assert bound(model, actuator=index) == sg.NONE
    assert bound(model, sensors=(0.0, index)) == sg.NONE
    assert bound(model, sensors=(index, 0.0)) == sg.NONE


def test_sensors_and_actuators_are_those_of_the_instance():
    model = rig(reel="reel")
    assert bound(model, actuator=0.0) != sg.NONE
    assert bound(rig(), sensors=(0.0, 0.0)) != sg.NONE
