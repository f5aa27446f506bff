"""A recompiled model finds in the state that it takes over what it itself says.

`MjSpec.recompile` hands on the numbers of each instance whose name and size are as before.
"""

import mujoco
import numpy as np
import pytest

from tendon_mj import Parameters, add_friction, add_tendon
from tendon_mj.plugin import sheaths
from tendon_mj.plugin.sheath_plugin.state import view
from tests.plugin.test_names import PLAIN, SPOOL
from tests.rigs import hands_on_plugin_states, restore, simulated, snapshot

pytestmark = pytest.mark.filterwarnings("ignore:add_friction. friction has no effect")


def hand(**more):
    """Two sheathed tendons, the first with a spool."""
    spec = mujoco.MjSpec.from_string(PLAIN)
    add_tendon(spec, "straight", ["a", "b"])
    law = {"axial_stiffness": 1e3, "pretension": 1.0}
    add_friction(spec, "flexor", friction=0.1, name="one", **law, **more)
    return add_friction(spec, "straight", friction=0.2, name="two", **law)


def moving(spec, steps=5):
    model = spec.compile()
    data = simulated(model, steps)
    return model, data


def plugin(spec, name):
    return next(p for p in spec.plugins if p.name == name)


def remove(spec, sheath):
    """Remove a sheath and what shows it."""
    tendon = plugin(spec, sheath).config["tendon"]
    for sensor in list(spec.sensors):
        if sensor.plugin.name == sheath or sensor.objname == tendon:
            spec.delete(sensor)
    for instance in list(spec.plugins):
        if instance.name.startswith(sheath):
            spec.delete(instance)


@hands_on_plugin_states
def test_an_unchanged_sheath_goes_on_a_changed_parameter_counts_and_a_live_one_stays():
    spec = hand(**SPOOL)
    model, data = moving(spec)
    mujoco.mj_forward(model, data)
    before = data.sensordata.copy()
    model, data = spec.recompile(model, data)
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(data.sensordata, before, rtol=1e-12)
    Parameters(model, data)["two.friction"] = 0.3
    changed = plugin(spec, "one")
    changed.config = {**changed.config, "friction": "0.5"}
    body = spec.worldbody.add_body(pos=[5, 0, 0])
    body.add_joint(name="elsewhere")
    body.add_geom(size=[0.1, 0, 0])
    model, data = spec.recompile(model, data)
    mujoco.mj_forward(model, data)
    assert Parameters(model, data)["one.friction"] == 0.5
    assert Parameters(model, data)["two.friction"] == 0.3


def test_the_sensors_of_a_sheath_that_stays_show_it():
    spec = hand()
    model, data = moving(spec)
    remove(spec, "one")
    model, data = spec.recompile(model, data)
    mujoco.mj_forward(model, data)
    assert data.sensor("two_input_tension").data[0] > 0.5
    np.testing.assert_array_equal(
        data.sensor("two_input_tension").data, data.sensor("two").data[:1]
    )


def test_a_joint_in_front_of_the_spool_s_may_go():
    spec = hand(**SPOOL)
    model, data = moving(spec)
    turned = float(data.joint("motor").qpos[0])
    spec.delete(spec.joint("knuckle"))
    model, data = spec.recompile(model, data)
    mujoco.mj_forward(model, data)
    fresh = mujoco.MjData(model)
    fresh.joint("motor").qpos[0] = turned
    mujoco.mj_forward(model, fresh)
    tensions = [each.sensor("input_tension").data for each in (data, fresh)]
    np.testing.assert_allclose(*tensions, rtol=0.2)
    state = view(data.plugin_state, sheaths(model)["one"].state).state
    assert state.reel_joint == model.joint("motor").id


def test_swapped_tendons_are_told_apart():
    """Sizes and configurations are the same, the indices are not."""

    def rig(first, second):
        spec = mujoco.MjSpec.from_string(PLAIN.replace('name="flexor"', 'name="gone"'))
        add_tendon(spec, first, ["a", "b"])
        add_tendon(spec, second, ["a", "b"])
        law = {"friction": 0.1, "axial_stiffness": 1e3, "pretension": 1.0}
        return add_friction(spec, "near", name="sheath", **law).compile()

    one, other = rig("near", "away"), rig("away", "near")
    data = simulated(one, 3)
    taken = mujoco.MjData(other)
    restore(other, taken, snapshot(one, data))
    mujoco.mj_forward(other, taken)
    state = view(taken.plugin_state, sheaths(other)["sheath"].state).state
    assert state.tendon == other.tendon("near").id
