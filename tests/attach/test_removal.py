"""Friction taken off again leaves the model that there was."""

import mujoco
import numpy as np
import pytest

from tendon_mj import add_friction, add_sensor, add_servo, remove_friction
from tendon_mj.errors import InvalidValueError, UnknownNameError
from tendon_mj.plugin import sheaths
from tests.refusals import refusing
from tests.rigs import FINGER, finger

INLINE = """
  <extension><plugin plugin="tendon_mj.sheath"><instance name="tube">
    <config key="tendon" value="flexor"/><config key="axial_stiffness" value="10"/>
    <config key="friction" value="0.1"/></instance></plugin></extension>
  <sensor><jointpos name="angle" joint="mcp"/>
    <plugin name="shown" plugin="tendon_mj.sheath"><config key="tendon" value="flexor"/>
      <config key="sensor" value="slip"/></plugin></sensor></mujoco>"""


def numbers(model):
    """All arrays of a model; its sizes, but for the length of its buffer."""
    values = {}
    for field in dir(model):
        value = getattr(model, field)
        if isinstance(value, np.ndarray | int) and field[0] != "_" and field != "signature":
            values[field] = np.array(value)
    return values


def assert_equal(one, other):
    before, after = numbers(one), numbers(other)
    assert before.keys() == after.keys()
    for field, value in before.items():
        np.testing.assert_array_equal(value, after[field], err_msg=field)


@pytest.mark.parametrize("tendon", ["flexor", ["flexor", "extensor"], "*"])
@pytest.mark.parametrize("between", ["nothing", "compiled", "copied", "written"])
@pytest.mark.parametrize("given", [{}, {"axial_stiffness": 500.0, "pretension": 1.0}])
def test_adding_and_removing_leaves_every_number_as_it_was(tendon, between, given):
    before = finger().compile()
    spec = add_friction(finger(), tendon, friction=0.1, **given)
    if between == "compiled":
        spec.compile()
    if between == "copied":
        spec = spec.copy()
    if between == "written":
        spec = mujoco.MjSpec.from_string(spec.to_xml())
    assert remove_friction(spec, tendon) is spec
    assert not [*spec.sensors, *spec.plugins, *spec.texts]
    after = spec.compile()
    if between != "written":  # which writes six digits
        assert_equal(before, after)
    np.testing.assert_array_equal(before.tendon_stiffness, after.tendon_stiffness)


@pytest.mark.parametrize("springlength", ["-1 -1", ".1 .2", "0 9"])
def test_so_it_does_whatever_spring_the_tendon_has(springlength):
    text = FINGER.format(more="").replace("0 .29", springlength)
    before = mujoco.MjSpec.from_string(text).compile()
    spec = add_friction(mujoco.MjSpec.from_string(text), "*", friction=0.3)
    assert_equal(before, remove_friction(spec, "*").compile())


def test_reel_spool_sensors_and_odd_springs_go_and_come_with_the_sheath():
    text = FINGER.format(more="").replace("400", "1 2 3").replace("300", "0")
    before = mujoco.MjSpec.from_string(text).compile()
    spec = mujoco.MjSpec.from_string(text)
    for tendon in ("extensor", "flexor"):
        given = {"axial_stiffness": 500.0, "pretension": 1.0, "name": f"{tendon}_tube"}
        end = {"output_joint": "pip", "output_radius": 0.01}
        add_friction(spec, tendon, friction=0.1, reel=f"{tendon}_reel", **given, **end)
        add_sensor(spec, f"{tendon}_tube", "slip", name=f"{tendon}_slip")
    assert_equal(before, remove_friction(spec, "*").compile())


def test_the_other_sheaths_stay_as_they_are():
    spec = add_friction(finger(), "*", friction=0.1)
    alone = add_friction(finger(), ["extensor"], friction=0.1)
    remove_friction(spec, "flexor")
    assert [s.name for s in spec.sensors] == [s.name for s in alone.sensors]
    assert_equal(spec.compile(), alone.compile())


def test_friction_can_be_added_changed_and_removed_again_and_again():
    spec, before = finger(), finger().compile()
    for k in range(3):
        add_friction(spec, "*", friction=0.1 * k)
        assert len(sheaths(spec.compile())) == 2
        remove_friction(spec, "*")
    assert_equal(before, spec.compile())


def test_a_spring_that_the_user_gave_since_stays():
    spec = add_friction(finger(), "flexor", friction=0.1)
    spec.tendon("flexor").stiffness[0] = 7.0
    remove_friction(spec, "flexor")
    assert spec.tendon("flexor").stiffness[0] == 7.0
    assert not spec.texts


def test_sensors_with_a_config_of_their_own_go_with_their_sheath():
    text = FINGER.format(more="").replace(' stiffness="300"', "").replace("</mujoco>", INLINE)
    spec = remove_friction(mujoco.MjSpec.from_string(text), "flexor")
    assert spec.compile().nplugin == 0
    assert [s.name for s in spec.sensors] == ["angle"]


def test_what_has_no_sheath_is_refused_by_name_and_left_out_of_a_pattern():
    spec = add_friction(finger(), "flexor", friction=0.1)
    for tendon, fact in (
        ("extensor", "'extensor'"),
        (["flexor", "extensor"], "'extensor'"),
        ("flexr", "did you mean 'flexor'"),
    ):
        with refusing((InvalidValueError, UnknownNameError), fact):
            remove_friction(spec, tendon)
    assert len(sheaths(spec.compile())) == 1
    assert not sheaths(remove_friction(spec, "*").compile())


def test_what_a_servo_or_a_sensor_of_the_user_s_needs_is_not_taken_away():
    spec = add_friction(finger(), "flexor", friction=0.1, reel_joint="mcp", reel_radius=0.01)
    add_servo(spec, "flexor", tension_gain=1.0, velocity_gain=0.1, motor_inertia=1e-4)
    with refusing(InvalidValueError, "servo", "'flexor'"):
        remove_friction(spec, "flexor")
    assert len(sheaths(spec.compile())) == 1
    spec = add_friction(finger(), "flexor", friction=0.1, reel="reel")
    spec.add_sensor(
        name="wound", type=mujoco.mjtSensor.mjSENS_ACTUATORFRC,
        objtype=mujoco.mjtObj.mjOBJ_ACTUATOR, objname="reel",
    )  # fmt: skip
    with refusing(InvalidValueError, "'wound'", "'reel'"):
        remove_friction(spec, "flexor")
    assert spec.compile().nu == 1
