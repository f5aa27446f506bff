"""Play as parameters of a recorded rig, and limits as parameters."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from tendon_mj.attach import add_cable_drive, add_friction
from tendon_mj.lab.diagnosis import Problem, all_samples, candidates, describe_system
from tendon_mj.lab.replay import Adjustable, Simulator, patch_model, replay_recording
from tendon_mj.models import load_model
from tests.lab.recorded import recorded

ARM = """<mujoco><compiler angle="degree"/>
<option timestep=".001" integrator="implicitfast" gravity="0 {g} 0"/>
<worldbody><site name="a"/><site name="b" pos=".1 0 0"/>
<body pos=".2 0 0"><inertial pos="0 -.2 0" mass=".5" diaginertia=".01 .01 .01"/>
<joint name="arm" damping="1" {more}/></body>
<body pos="1 0 0"><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
<joint name="stop" range="-10 20"/></body></worldbody>
<tendon>
<spatial name="one"><site site="a"/><site site="b"/></spatial>
<spatial name="two"><site site="a"/><site site="b"/></spatial>
</tendon>
<sensor><jointpos name="angle" joint="arm"/></sensor></mujoco>"""
RADIUS, WIDTH = 0.03, 0.04
TIME = np.arange(0.0, 6.0, 0.03)


def arm(folder, g=-9.81, more="", stiffness=2e3, turned=("arm", "arm")):
    """An arm that hangs from a pulley, which two cables turn; or two arms, with one cable each."""
    spec = mujoco.MjSpec.from_string(ARM.format(g=g, more=more))
    for tendon, side, joint in zip(("one", "two"), (-1.0, 1.0), turned, strict=True):
        law = {"friction": 0.2, "axial_stiffness": stiffness, "pretension": 30.0, "extra_bend": 1.0}
        ends = {"reel": f"{tendon}_reel", "output_joint": joint, "output_radius": side * RADIUS}
        add_friction(spec, tendon, inner_guides=3, sensors=("input_tension",), **law, **ends)
    path = folder / "arm.xml"
    path.write_text(spec.to_xml())
    return path


def motion(path, wave=None, drive=None):
    if drive is not None:
        still = 0.0 * TIME
        read = {"read_N": ("j_cable_input_tension", 0.2)}
        return recorded(TIME, {"drive_rad": (drive, still)}, read, path, settling_time=None)
    drive = RADIUS * 0.3 * (1.0 - np.cos(1.5 * TIME)) if wave is None else wave
    return recorded(
        TIME,
        {"one_m": ("one_reel", drive), "two_m": ("two_reel", -drive)},
        {"arm_rad": ("angle", 1e-3), "one_N": ("input_tension", 0.2)},
        path,
        settling_time=None,
    )


def width(of=WIDTH):
    """Parameters of a play between the arm and its pulley."""
    return {f"{cable}_sheath.output_play": of for cable in ("one", "two")}


def test_the_load_decides_on_which_flank_the_joint_is(tmp_path):
    held = np.interp(TIME, [0.0, 3.0], [0.0, RADIUS * 0.5])
    for sign in (1.0, -1.0):
        made = motion(arm(tmp_path), sign * held)
        turned, with_play = (
            replay_recording(made, parameters=values).columns["arm_rad"][-1]
            for values in ({}, width())
        )
        assert with_play - turned == pytest.approx(-sign * WIDTH / 2.0, rel=0.05)


@pytest.mark.parametrize("side", [40, -40])
def test_a_joint_that_is_loaded_where_angles_are_zeroed_begins_on_its_flank(tmp_path, side):
    made = motion(arm(tmp_path, more=f'stiffness="2" springref="{side}"'), np.zeros(TIME.size))
    shown = replay_recording(made, parameters=width())
    assert abs(shown.columns["arm_rad"] - replay_recording(made).columns["arm_rad"]).max() < 1e-3


def test_a_joint_whose_weight_is_compensated_rests_in_the_middle(tmp_path):
    path = arm(tmp_path)
    text = path.read_text().replace('springref="0"', "")
    for body, rest in (("<body", -1.0), ('<body gravcomp="1"', 0.0)):
        path.write_text(
            text.replace("-9.81 0", "0 0")
            .replace('gravity="0', 'gravity="-9')
            .replace("<body", body)
        )
        values = Adjustable(load_model(str(path))).parameters()
        assert values["one_sheath.output_rest"].value == rest


def test_play_is_of_the_joint_s_unit_and_the_longest_step_sees_it(tmp_path):
    made = motion(arm(tmp_path))
    own = Simulator([made], threads=1)
    assert own.parameters["one_sheath.output_play"].unit == "rad"
    ((coarse,),), ((fine,),) = own.in_steps(2.0)([width()]), own.in_steps(0.5)([width()])
    for column, measured in made.measured.items():
        assert abs(coarse[column] - fine[column]).max() < 2.0 * measured.noise


def test_a_written_model_has_the_play_that_was_simulated(tmp_path):
    path = arm(tmp_path, more='stiffness="2" springref="40"')
    made, values = motion(path), {**width(), "arm.damping": 0.2}
    ((simulated,),) = Simulator([made])([values])
    model = load_model(str(patch_model(made.model, values, tmp_path / "played.xml")))
    shown = replay_recording(made, model)
    assert np.array_equal(shown.columns["arm_rad"], simulated["arm_rad"])
    assert Adjustable(model).parameters()["two_sheath.output_play"].value == WIDTH


def test_limits_of_a_model_are_parameters(tmp_path):
    path = arm(tmp_path)
    known = Adjustable(load_model(str(path))).parameters()
    ends = [known[f"stop.range_{end}"].value for end in ("low", "high", "width")]
    assert ends == pytest.approx(np.radians([-10.0, 20.0, 30.0]))
    for values in ({"stop.range_width": 1.0}, {"stop.range_low": -1 / 3, "stop.range_high": 2 / 3}):
        written = load_model(str(patch_model(path, values, tmp_path / "limited.xml")))
        assert written.joint("stop").range == pytest.approx([-1 / 3, 2 / 3])


def driven(folder):
    """A joint with a load that a servo turns by two cables, which share a drum."""
    spec = mujoco.MjSpec.from_string("""<mujoco><option timestep=".001" integrator="implicitfast"/>
    <worldbody><body><joint name="j" axis="0 1 0" damping=".01"/>
    <geom size=".02" pos="0 0 -.1" mass=".1"/></body></worldbody>
    <actuator><position name="m" joint="j" kp="4" kv=".1"/></actuator></mujoco>""")
    cable = {"radius": 0.01, "bend": 3.0, "friction": 0.1, "pretension": 20.0, "armature": 0.002}
    cable |= {"motor": True, "axial_stiffness": 5e3, "length": 0.5}
    add_cable_drive(spec, "m", **cable)
    path = folder / "driven.xml"
    path.write_text(spec.to_xml())
    return path


def test_one_play_is_of_all_cables_on_a_drum_or_pulley(tmp_path):
    """A drum on which one cable alone winds rests on its flank."""

    def plays(made):
        problem = Problem((made,), Simulator([made], threads=1), all_samples([made]))
        known = candidates(describe_system(problem))
        return {c.where: c.terms[0].targets for c in known if c.identifier.endswith("_play")}

    both = ("j_cable_back_sheath", "j_cable_sheath")
    found = plays(motion(driven(tmp_path), drive="m"))
    assert found["j"] == tuple(f"{sheath}.output_play" for sheath in both)
    assert found["j_motor"] == tuple(f"{sheath}.reel_play" for sheath in both)
    assert [*plays(motion(arm(tmp_path)))] == ["arm"]
