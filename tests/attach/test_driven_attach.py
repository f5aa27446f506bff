"""Friction on tendons that actuators pull, that wrap or that branch; on models of others."""

import math
import os
import warnings
from pathlib import Path

import mujoco
import numpy as np
import pytest

from tendon_mj import Parameters, TendonWarning, add_friction, remove_friction, view_sheath
from tendon_mj.attach import attach_friction
from tendon_mj.errors import InvalidValueError
from tendon_mj.lab.replay import Adjustable
from tendon_mj.models import load_spec
from tendon_mj.plugin import sheaths
from tests.attach.test_removal import assert_equal
from tests.refusals import refusing, silent
from tests.rigs import driven_xml, needs_aero_hand, simulated, spatial

STIFF = spatial("stiff", "a k c", 'stiffness="70" damping=".1"')
MOTORS = """<motor name="motor" tendon="wrapped"/><position name="servo" tendon="wrapped" kp="1"/>
  <motor name="stiff_motor" tendon="stiff"/><motor name="elbow_motor" joint="elbow"/>"""
ARM = driven_xml(STIFF, MOTORS, joint="")
OF_A_REEL = (
    "pretension", "backlash", "sheath_compliance", "output_compliance", "viscous_friction",
    "tendon_mass",
)  # fmt: skip
GIVEN = Path(os.environ.get("TENDON_MJ_MODELS", "/nowhere"))
MODELS = [
    pytest.param(path, id=path.stem, marks=[needs_aero_hand] if path.stem == "aero_hand" else [])
    for path in sorted(GIVEN.glob("*.xml"))
]
on_models_of_others = pytest.mark.parametrize("path", MODELS)


def arm():
    return mujoco.MjSpec.from_string(ARM)


def config(spec, tendon):
    return spec.plugin(f"{tendon}_sheath").config


@pytest.mark.parametrize("tendon", ["wrapped", "sprung"])
@pytest.mark.parametrize(
    ("parameter", "why"),
    [
        *((name, "gives the input tension of tendon ") for name in OF_A_REEL),
        ("reel_radius", "without reel_joint"),
        ("output_radius", "without output_joint"),
    ],
)
def test_what_compiling_refuses_of_a_driven_tendon_is_refused_live_too(tendon, parameter, why):
    model = add_friction(arm(), "*", friction=0.1, arc_guides=3).compile()
    data = mujoco.MjData(model)
    name, before = f"{tendon}_sheath.{parameter}", data.plugin_state.copy()
    parameters = Parameters(model, data)
    assert name not in parameters
    assert name not in list(parameters)
    for call in (
        lambda: parameters.update({name: 0.01}),
        lambda: setattr(view_sheath(model, data, tendon), parameter, 0.01),
        lambda: Adjustable(model).set({f"{tendon}_sheath.friction": 0.2, name: 0.01}),
    ):
        with refusing(InvalidValueError, name, why):
            call()
    np.testing.assert_array_equal(data.plugin_state, before)


def test_what_an_actuator_pulls_is_driven_by_it_and_needs_no_elasticity():
    spec = add_friction(arm(), "*", friction=0.1, arc_guides=3)
    for tendon in ("wrapped", "stiff"):
        assert not {"axial_stiffness", "pretension"} & set(config(spec, tendon))
    given = {"tendon": "wrapped", "friction": "0.1", "guides": "4", "arc_guides": "3"}
    assert config(spec, "wrapped").items() >= given.items()
    assert "arc_guides" not in config(spec, "stiff"), "it wraps around nothing"
    assert spec.compile().nplugin == 4 + 2, "sensors of a kind share an instance"


def limited_arm(joint="", tendon=""):
    limits = ARM.replace('damping=".01" ', f'damping=".01" {joint} ')
    return mujoco.MjSpec.from_string(limits.replace('name="stiff" ', f'name="stiff" {tendon} '))


@pytest.mark.parametrize(
    "limit", ['actuatorfrcrange="-1 1"', 'actuatorfrcrange="-1 1" actuatorfrclimited="true"']
)
def test_a_joint_that_limits_what_a_driven_tendon_does_there_is_warned_of(limit):
    with pytest.warns(TendonWarning, match="'elbow' .*'stiff' .*actuatorfrcrange.*forcerange"):
        add_friction(limited_arm(limit), "stiff", friction=0.1)


@pytest.mark.parametrize(
    ("limits", "tendon"),
    [
        ({"joint": 'actuatorfrcrange="-1 1" actuatorfrclimited="false"'}, "stiff"),
        ({"joint": 'actuatorfrcrange="-1 1"'}, "sprung"),  # wound, its spring no actuator
        ({"tendon": 'actuatorfrcrange="-1 1"'}, "stiff"),
        ({}, "stiff"),
    ],
)
def test_of_no_other_limit(limits, tendon):
    with silent(TendonWarning):
        add_friction(limited_arm(**limits), tendon, friction=0.1)


PULLS = [
    "<motor {}/>",
    '<motor {} ctrlrange="-5 0"/>',
    '<motor {} gear="-2" ctrlrange="0 5"/>',
    '<motor {} ctrlrange="-5 5" forcerange="-3 0"/>',
    "<muscle {}/>",
    '<position {} kp="100" forcerange="-9 0"/>',
    '<general {} gaintype="user"/>',
    '<cylinder {} area="2" bias="-1 0 0" ctrlrange="-1 .5"/>',
]
PUSHES = [
    '<motor {} ctrlrange="-1 1"/>',
    '<motor {} forcerange="-9 1"/>',
    '<motor {} gear="-2" ctrlrange="-5 0"/>',
    '<position {} kp="100" ctrlrange=".1 .2"/>',
    '<velocity {} kv="1" forcerange="-9 9"/>',
    '<intvelocity {} kp="1" actrange="0 1"/>',
    '<cylinder {} area="2" bias="-1 0 0" ctrlrange="-1 .6"/>',
    '<muscle {}/><motor {} ctrlrange="0 2"/>',
]


def driven_by(actuator):
    on_stiff = actuator.replace("{}", 'tendon="stiff"')
    return mujoco.MjSpec.from_string(
        ARM.replace('<motor name="stiff_motor" tendon="stiff"/>', on_stiff)
    )


@pytest.mark.parametrize("actuator", PULLS)
def test_what_can_only_pull_is_not_warned_of(actuator):
    with silent():
        add_friction(driven_by(actuator), "stiff", friction=0.1)


@pytest.mark.parametrize("actuator", PUSHES)
def test_what_can_push_is_warned_of_once_a_call(actuator):
    with pytest.warns(TendonWarning) as caught:
        add_friction(driven_by(actuator), ["stiff", "wrapped"], friction=0.1)
    (said,) = caught
    assert "push" in str(said.message)
    assert "'wrapped', 'stiff'" in str(said.message)


def test_a_push_passes_the_sheath_without_friction_and_without_tension():
    with pytest.warns(TendonWarning, match="'stiff'.* can only push"):
        spec = add_friction(driven_by('<motor {} ctrlrange="0 5"/>'), "stiff", friction=0.5)
    model, plain = spec.compile(), driven_by('<motor {} ctrlrange="0 5"/>').compile()
    answers = []
    for one in (model, plain):
        one.tendon_stiffness[:] = 0.0
        data = mujoco.MjData(one)
        data.ctrl[2] = 5.0
        mujoco.mj_step(one, data, 20)
        answers.append(data.qpos.copy())
    np.testing.assert_allclose(*answers)
    pushed = mujoco.MjData(model)
    pushed.ctrl[2] = 5.0
    mujoco.mj_forward(model, pushed)
    assert view_sheath(model, pushed, "stiff").input_tension == 0.0


def test_a_tendon_s_limit_is_its_input_tension():
    model = add_friction(
        limited_arm(tendon='actuatorfrcrange="-1 1" actuatorfrclimited="true"'),
        "stiff",
        friction=0.1,
    ).compile()
    data = mujoco.MjData(model)
    data.actuator("stiff_motor").ctrl = -5.0
    mujoco.mj_forward(model, data)
    spring = 70.0 * (model.tendon_lengthspring[3] - data.ten_length[3])[0]
    assert view_sheath(model, data, "stiff").input_tension == pytest.approx(1.0 - spring)


def test_elements_of_a_driven_tendon_stay_as_they_are():
    spec, plain = add_friction(arm(), "*", friction=0.1), arm().compile()
    model = spec.compile()
    for field in ("tendon_stiffness", "tendon_damping", "tendon_lengthspring", "actuator_gainprm"):
        np.testing.assert_array_equal(getattr(model, field), getattr(plain, field), err_msg=field)
    assert not spec.texts


def test_a_spring_without_an_actuator_drives_where_it_cannot_move_into_the_sheath():
    spec = add_friction(arm(), ["sprung", "branched"], friction=0.1)
    assert [config(spec, t)["guides"] for t in ("sprung", "branched")] == ["1", "2"]
    for tendon in ("sprung", "branched"):
        assert "pretension" not in config(spec, tendon)
        assert spec.tendon(tendon).stiffness[0] > 0.0
    spec.compile()


def test_an_axial_stiffness_that_is_given_is_that_of_a_driven_tendon():
    tendons = ["wrapped", "sprung"]
    spec = add_friction(arm(), tendons, friction=0.1, axial_stiffness=5e3)
    assert [config(spec, tendon)["axial_stiffness"] for tendon in tendons] == ["5000.0"] * 2
    spec.compile()


@pytest.mark.parametrize("tendon", ["wrapped", ["wrapped"], "*"])
def test_a_pretension_of_a_driven_tendon_is_refused(tendon):
    spec = arm()
    before = spec.to_xml()
    with refusing(InvalidValueError, "'wrapped'", "'motor' and 'servo'", "pretension"):
        add_friction(spec, tendon, friction=0.1, pretension=1.0)
    assert spec.to_xml() == before


def test_what_is_wound_besides_takes_its_elasticity_as_before():
    with refusing(InvalidValueError, "'wrapped'", "axial_stiffness"):
        add_friction(arm(), "wrapped", friction=0.1, output_joint="elbow", output_radius=0.01)
    spec = add_friction(arm(), "stiff", friction=0.1, output_joint="elbow", output_radius=0.01)
    assert spec.plugin("stiff_sheath").config["spring"] == "cable"
    assert spec.tendon("stiff").stiffness.any()  # the sheath reads it


def test_without_its_friction_a_driven_model_is_what_it_was():
    spec = add_friction(arm(), "*", friction=0.3, arc_guides=2)
    spec.compile()
    assert_equal(arm().compile(), remove_friction(spec, "*").compile())


@on_models_of_others
def test_a_pattern_accepts_every_tendon_that_something_pulls_on_a_model_of_others(path):
    spec = mujoco.MjSpec.from_file(str(path))
    plain = spec.compile()
    on = plain.actuator_trntype == mujoco.mjtTrn.mjTRN_TENDON.value
    pulled = {plain.tendon(int(k)).name for k in plain.actuator_trnid[on, 0]}
    pulled |= {plain.tendon(k).name for k in np.flatnonzero(plain.tendon_stiffness)}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", TendonWarning)
        add_friction(spec, "*", friction=0.1)
    model = spec.compile()
    assert {sheath.tendon for sheath in sheaths(model).values()} == pulled
    data = simulated(model, 20)
    assert np.isfinite(data.qpos).all()
    assert_equal(plain, remove_friction(spec, "*").compile())


@on_models_of_others
def test_a_model_of_others_is_written_with_friction(path, tmp_path):
    attached = attach_friction(load_spec(str(path)), path, "*", tmp_path / "new.xml", friction=0.1)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "new.xml"))
    sheathed = {row.tendon for row in attached.rows if row.sheath}
    assert {sheath.tendon for sheath in sheaths(model).values()} == sheathed
    for row in attached.rows:
        assert 0.0 <= row.least_bend <= row.bend <= row.most_bend
        assert row.transmission == pytest.approx(math.exp(-0.1 * row.bend))


def test_a_sensor_of_the_actuators_at_a_joint_is_said_to_know_nothing_of_friction():
    spec = arm()
    spec.add_sensor(
        name="moment",
        type=mujoco.mjtSensor.mjSENS_JOINTACTFRC,
        objtype=mujoco.mjtObj.mjOBJ_JOINT,
        objname="elbow",
    )
    with pytest.warns(TendonWarning, match=r"'moment'.*qfrc_passive"):
        add_friction(spec, "*", friction=0.1)
