"""Friction for a tendon that a model already has."""

import mujoco
import numpy as np
import pytest

from tendon_mj import Parameters, add_friction, add_sensor, remove_friction
from tendon_mj.errors import InvalidValueError, TendonWarning, UnknownNameError
from tendon_mj.plugin import KINDS, sheaths
from tests.refusals import refusing
from tests.rigs import finger as rig
from tests.rigs import simulated

SUM = '<fixed name="sum"><joint joint="mcp" coef="1"/><joint joint="pip" coef="1"/></fixed>'


def finger(k=400.0, s=(0.0, 0.29)):
    """The finger with two tendons alike, and one that is fixed."""
    spec = rig(SUM)
    spec.option.timestep = 0.0005
    for tendon in ("extensor", "flexor"):
        spec.tendon(tendon).stiffness[0], spec.tendon(tendon).springlength = k, s
    return spec


def both(spec, friction, **values):
    """Friction on both tendons, a reel on each."""
    for tendon in ("extensor", "flexor"):
        add_friction(spec, tendon, friction=friction, reel=f"{tendon}_reel", **values)
    return spec


def test_the_tendon_keeps_its_force_at_qpos0():
    plain = finger().compile()
    model = both(finger(), 0.2).compile()
    one, other = mujoco.MjData(plain), mujoco.MjData(model)
    mujoco.mj_forward(plain, one)
    mujoco.mj_forward(model, other)
    tension = 400.0 * (plain.tendon_length0[0] - 0.29)
    assert tension > 1.0
    assert other.sensor("input_tension").data[0] == pytest.approx(tension, rel=1e-9)
    np.testing.assert_allclose(other.qfrc_passive, one.qfrc_passive, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("springlength", [(0.0, 0.29), (0.0, 0.33), (-1.0, -1.0)])
def test_without_friction_the_model_moves_as_before(springlength):
    plain = finger(s=springlength).compile()
    if springlength == (-1.0, -1.0):  # as long as it is, and it must not push
        plain.tendon_lengthspring[:2, 0] = 0.0
    model = both(finger(s=springlength), 0.0).compile()
    one, other = mujoco.MjData(plain), mujoco.MjData(model)
    one.qvel[:] = other.qvel[:] = [1.0, -2.0]
    paths = np.empty((2, 2000, 2))
    for k in range(2000):
        mujoco.mj_step(plain, one)
        mujoco.mj_step(model, other)
        paths[:, k] = one.qpos, other.qpos
    assert np.abs(paths[0] - paths[1]).max() <= 1e-9 * np.abs(paths).max()


def test_what_is_given_goes_before_what_the_tendon_had():
    spec = add_friction(finger(), "flexor", friction=0.1, axial_stiffness=900.0, pretension=3.0)
    config = spec.plugin("flexor_sheath").config
    assert (config["axial_stiffness"], config["pretension"]) == ("900.0", "3.0")
    data = mujoco.MjData(model := spec.compile())
    mujoco.mj_forward(model, data)
    assert data.sensor("output_tension").data[0] == pytest.approx(3.0, rel=1e-9)


def test_names_of_sheaths_reels_and_sensors():
    spec = both(finger(), 0.1)
    model = spec.compile()
    assert set(sheaths(model)) == {"extensor_sheath", "flexor_sheath"}
    assert {s.tendon for s in sheaths(model).values()} == {"extensor", "flexor"}
    assert [a.name for a in spec.actuators] == ["extensor_reel", "flexor_reel"]
    assert [s.name for s in spec.sensors] == [
        "input_tension",
        "output_tension",
        "flexor_input_tension",
        "flexor_output_tension",
    ]
    alike = add_friction(finger(), ["flexor"], friction=0.1, reel="pull")
    assert [s.name for s in alike.sensors] == ["flexor_input_tension", "flexor_output_tension"]
    assert list(sheaths(alike.compile())) == ["flexor_sheath"]
    named = add_friction(finger(), "flexor", friction=0.1, name="tube", sensors=())
    assert set(sheaths(named.compile())) == {"tube"}
    assert [s.name for s in named.sensors] == ["tube"], "something refers to the sheath"


@pytest.mark.parametrize("kind", list(KINDS))
def test_every_kind_of_sensor_can_be_added_and_shows_as_much_as_it_says(kind):
    spec = add_friction(finger(), "flexor", friction=0.1, sensors=())
    sensor = add_sensor(spec, "flexor_sheath", kind, name="shown")
    model = spec.compile()
    assert sensor.name == "shown"
    assert model.sensor("shown").dim[0] == {"one": 1, "segment": 2, "guide": 1}[KINDS[kind][2]]


def test_a_reel_winds_in_what_its_control_says():
    spec = add_friction(
        finger(), "flexor", friction=0.1, reel="reel", sensors=("reel_displacement", "tension")
    )
    model = spec.compile()
    data = simulated(model)
    before = data.sensor("tension").data.copy()
    data.actuator("reel").ctrl[0] = 2e-3
    mujoco.mj_forward(model, data)
    assert data.sensor("reel_displacement").data[0] == 2e-3
    assert np.all(data.sensor("tension").data > before)
    model.actuator("reel").ctrlrange[:] = [-1e-3, 1e-3]
    model.actuator_ctrllimited[:] = 1
    mujoco.mj_forward(model, data)
    assert data.sensor("reel_displacement").data[0] == 1e-3


@pytest.mark.parametrize(
    ("given", "facts"),
    [
        ({"tendon": "flexr"}, ["flexr", "did you mean 'flexor'"]),
        ({"tendon": None}, ["None"]),
        ({"tendon": [None]}, ["None"]),
        ({"tendon": "sum", "axial_stiffness": 1.0, "pretension": 0.0}, ["sum", "add_cable_drive"]),
        ({"sensors": ("slipp",)}, ["slipp", "did you mean 'slip'"]),
        ({"sensors": ("slip", "slip")}, ["slip"]),
        ({"friction": -0.1}, ["friction = -0.1"]),
        ({"friction": np.nan}, ["friction = nan"]),
        ({"friction": None}, ["friction = None"]),
        ({"pretension": -1.0}, ["pretension = -1"]),
        ({"axial_stiffness": 0.0}, ["axial_stiffness = 0"]),
        ({"static_friction": 0.05}, ["static_friction", "0.05"]),
        ({"reel_joint": "nowhere", "reel_radius": 0.01}, ["reel_joint", "nowhere"]),
        ({"output_radius": 0.01}, ["output_joint", "output_radius"]),
        ({"name": ""}, ["name", "''"]),
        ({"name": 5}, ["name", "5"]),
    ],
    ids=str,
)
def test_what_cannot_be_added_is_refused_and_leaves_the_model_as_it_was(given, facts):
    spec = finger()
    before = spec.to_xml()
    with refusing((UnknownNameError, InvalidValueError), *facts):
        add_friction(spec, **{"tendon": "flexor", "friction": 0.1, **given})
    assert spec.to_xml() == before


def test_a_second_sheath_or_name_is_refused():
    spec = add_friction(finger(), "flexor", friction=0.1, name="one")
    with refusing(ValueError, "flexor", "sheath 'one'"):
        add_friction(spec, "flexor", friction=0.1)
    with refusing(ValueError, "'one'"):
        add_friction(spec, "extensor", friction=0.1, name="one")
    with refusing(UnknownNameError, "sheat", "'one'"):
        add_sensor(spec, "sheat", "slip")


def test_a_tendon_without_stiffness_must_be_given_one():
    with refusing(ValueError, "flexor", "axial_stiffness [N] and pretension [N]"):
        add_friction(finger(k=0.0), "flexor", friction=0.1)
    given = {"axial_stiffness": 100.0, "pretension": 1.0}
    assert add_friction(finger(k=0.0), "flexor", friction=0.1, **given).compile().nplugin == 3


def test_a_sheath_without_a_reel_survives_copies():
    spec = add_friction(finger(), "flexor", friction=0.1, sensors=())
    add_friction(spec, "extensor", friction=0.1, sensors=())
    assert len(sheaths(spec.copy().compile())) == 2


def test_a_sensor_on_the_sheath_shows_both_ends():
    spec = add_friction(finger(), "flexor", friction=0.3)
    model = spec.compile()
    data = simulated(model, 50, qvel=2.0)
    ends = [data.sensor(f"{end}_tension").data[0] for end in ("input", "output")]
    np.testing.assert_array_equal(data.sensor("flexor_sheath").data, ends)
    assert ends[0] != ends[1]


FORMS = {  # springs that no cable has: spring length, more stiffness
    "slack at qpos0": ((0.0, 9.0), 0.0),
    "springlength = 0": ((0.0, 0.0), 0.0),
    "dead band": ((0.1, 0.2), 0.0),
    "polynomial": ((0.0, 0.29), 10.0),
}


def odd(form):
    spec = finger(s=FORMS[form][0])
    spec.tendon("flexor").stiffness[1] = FORMS[form][1]
    return spec


@pytest.mark.parametrize("form", FORMS)
def test_a_spring_that_no_sheath_can_be_stays_and_drives_the_tendon(form):
    spec = odd(form)
    before = [*spec.tendon("flexor").stiffness, *spec.tendon("flexor").springlength]
    config = add_friction(spec, "flexor", friction=0.1).plugin("flexor_sheath").config
    assert not {"axial_stiffness", "pretension"} & set(config)
    assert [*spec.tendon("flexor").stiffness, *spec.tendon("flexor").springlength] == before
    assert not spec.texts


@pytest.mark.parametrize("more", [{"pretension": 1.0}, {"reel": "reel"}])
@pytest.mark.parametrize("form", FORMS)
def test_such_a_spring_is_not_replaced_in_silence(form, more):
    with refusing(ValueError, "flexor", form):
        add_friction(odd(form), "flexor", friction=0.1, **more)


def test_parameters_of_another_model_are_refused():
    one = add_friction(finger(), "flexor", friction=0.1).compile()
    other = both(finger(), 0.1).compile()
    with refusing(InvalidValueError, f"({other.npluginstate},)", str(one.npluginstate)):
        Parameters(one, mujoco.MjData(other))


@pytest.mark.parametrize("spec", ["hand.xml", None, mujoco.MjModel.from_xml_string("<mujoco/>")])
def test_only_a_spec_is_taken(spec):
    for call in (lambda: add_friction(spec, "t", friction=0.1), lambda: remove_friction(spec, "t")):
        with refusing(InvalidValueError, "mujoco.MjSpec", type(spec).__name__):
            call()


@pytest.mark.parametrize(("friction", "more"), [(2.1, {}), (15, {}), (0.2, {"static_friction": 4})])
def test_a_friction_in_percent_is_warned_of(friction, more):
    with pytest.warns(TendonWarning, match=r"friction = (2\.1|15|4) lets .* give 0\.(021|15|04)$"):
        add_friction(finger(), "flexor", friction=friction, **more)


def test_a_bend_in_degrees_is_warned_of():
    with pytest.warns(TendonWarning, match="extra_bend = 90 rad are 14 turns"):
        add_friction(finger(), "flexor", friction=0.1, extra_bend=90.0)


def test_the_friction_of_rubber_and_three_turns_are_not_warned_of():
    add_friction(finger(), "flexor", friction=2.0, extra_bend=19.0)  # warnings are errors
