"""The command that writes a model with friction."""

import json

import mujoco
import pytest

from tendon_mj import largest_stiffness
from tendon_mj.cli import console, main
from tendon_mj.plugin import sheaths
from tests.rigs import FINGER, LIMP, lever


@pytest.fixture
def finger(tmp_path):
    path = tmp_path / "finger.xml"
    path.write_text(FINGER.format(more=LIMP))
    return path


@pytest.fixture
def attach(tmp_path, monkeypatch):
    """Run the command; its status, what it printed in one line each row, and where it wrote."""
    monkeypatch.setattr(console, "width", 200)

    def run(path, *tendons, friction=0.15, out="new.xml", more=()):
        given = ["attach", str(path), "--tendon", *tendons, "--friction", str(friction)]
        with console.capture() as capture:
            status = main([*given, *more, "--out", str(tmp_path / out)])
        return status, capture.get(), tmp_path / out

    return run


def test_a_model_with_friction_is_written_and_its_tendons_are_shown(finger, attach):
    status, shown, out = attach(finger, "flex*", "extensor")
    assert status == 0
    for word in ("flexor", "extensor_sheath", "its spring", "e^(-μφ)", f"wrote {out}"):
        assert word in shown
    model = mujoco.MjModel.from_xml_path(str(out))
    assert {s.tendon for s in sheaths(model).values()} == {"flexor", "extensor"}


def test_what_is_left_out_is_said_with_the_reason(finger, attach):
    status, shown, _ = attach(finger, "*")
    assert status == 0
    assert "left as they are: 'limp': has no stiffness to take over" in shown
    assert "left as it was" in shown


@pytest.fixture
def attach_cables(tmp_path, monkeypatch):
    """Run the command for actuators of a lever; as `attach`."""
    path = tmp_path / "lever.xml"
    text = lever('<motor name="m" joint="j"/>', geom='size=".1" material="steel"')
    path.write_text(text.replace("<worldbody>", DEFAULTS + "<worldbody>"))
    monkeypatch.setattr(console, "width", 200)

    def run(*more, friction=".1"):
        written = str(tmp_path / "new.xml")
        given = ["attach", str(path), *more, "--friction", friction, "--out", written]
        with console.capture() as capture:
            status = main(given)
        return status, capture.get(), tmp_path / "new.xml"

    return run


DEFAULTS = """<default><tendon stiffness="7" damping="2" frictionloss="1"/></default>
  <!-- of a lever --><asset><material name="steel"/></asset>"""


def test_actuators_get_cables_that_the_file_does_not_draw(attach_cables):
    """Which take over nothing of its defaults."""
    cable = ("--radius", ".01", "--extra-bend", "3", "--pretension", "5")
    _, shown, _ = attach_cables("--actuator", "*", *cable, "--efficiency", ".8")
    assert "0.741 of its tension (0.593 with the gear), and loses 3 N at least" in shown
    status, shown, out = attach_cables("--actuator", "*", *cable)
    assert status == 0
    assert "0.741 of its tension, and loses 3 N at least, 0.03 N m" in shown
    model = mujoco.MjModel.from_xml_path(str(out))
    assert [s.tendon for s in sheaths(model).values()] == ["j_cable"]
    assert (model.tendon_stiffness[0], model.tendon_frictionloss[0]) == (0.0, 0.0)
    assert "<!-- of a lever -->" in out.read_text()


def test_actuators_get_motors_in_the_file(attach_cables):
    cable = ("--radius", ".01", "--extra-bend", "3", "--axial-stiffness", "2e3", "--length", ".3")
    status, _, out = attach_cables(
        "--actuator", "*", *cable, "--motor", "--armature", "1e-3", "--efficiency", ".8"
    )
    assert status == 0
    model = mujoco.MjModel.from_xml_path(str(out))
    assert [s.tendon for s in sheaths(model).values()] == ["j_cable", "j_cable_back", "j_gear"]
    assert model.actuator_trnid[0, 0] == model.joint("j_motor").id


@pytest.mark.skipif(not hasattr(mujoco, "mjtCtrlInput"), reason="another dcmotor")
@pytest.mark.parametrize(
    ("cable", "motor"),
    [
        (False, ()),
        (True, ()),
        (True, ("--motor", "--axial-stiffness", "2e3", "--length", ".3")),
    ],
)
def test_actuators_get_the_servo_of_a_file_of_bam(attach_cables, tmp_path, cable, motor):
    numbers = {"model": "m1", "kt": 2.2, "R": 2.4, "armature": 0.02, "friction_base": 0.1}
    servo = tmp_path / "m1.json"
    servo.write_text(json.dumps(numbers | {"friction_viscous": 0.05, "q_offset": 0.0}))
    drum, friction = (("--radius", ".01", "--extra-bend", "3"), ".1") if cable else ((), "0")
    volts = ("--servo-gain", "70.123456789", "--servo-voltage", "14")
    more = ("--servo", str(servo), *volts, *drum, *motor)
    status, _, out = attach_cables("--actuator", "*", *more, friction=friction)
    assert status == 0
    model = mujoco.MjModel.from_xml_path(str(out))
    assert model.actuator_gaintype[0] == mujoco.mjtGain.mjGAIN_DCMOTOR
    assert model.dof_armature.sum() == pytest.approx(0.02)
    assert model.dof_damping.sum() == pytest.approx(0.05)
    assert "servo_friction" in out.read_text()


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (("--tendon", "*", "--actuator", "*"), "give --tendon or --actuator"),
        (("--actuator", "*", "--radius", ".01"), "--extra-bend [rad]"),
        (("--actuator", "*", "--extra-bend", "3"), "--radius [m]"),
        (("--tendon", "*", "--motor"), "belong to --actuator"),
        (("--tendon", "*", "--servo", "m6.json"), "belong to --actuator"),
        (("--tendon", "*", "--servo-gain", "9"), "belong to --actuator"),
    ],
)
def test_options_of_cables_that_are_not_drawn_go_together(attach_cables, capsys, more, said):
    assert attach_cables(*more)[0] != 0
    assert said in capsys.readouterr().err


BROKEN = FINGER.format(more="").replace('site="f"', 'site="nowhere"')


@pytest.mark.parametrize(
    ("text", "tendon", "said"),
    [
        (None, "flexr", "did you mean 'flexor'"),
        (None, "limp", "'limp' has no stiffness to take over"),
        (None, "lim*", "none of the tendons matching 'lim*'"),
        (BROKEN, "flexor", "nowhere"),
        ("<mujoco><nothing/></mujoco>", "flexor", "Schema violation"),
        ("no XML", "flexor", "XML"),
        ("<!-- by J\udcf6rg -->" + FINGER.format(more=""), "flexor", "0xf6"),
    ],
)
def test_a_refusal_is_one_line_and_writes_nothing(finger, attach, capsys, text, tendon, said):
    if text is not None:
        finger.write_text(text, errors="surrogateescape")
    status, _, out = attach(finger, tendon)
    error = capsys.readouterr().err
    assert (status, error.count("\n"), out.exists()) == (2, 1, False)
    assert said in error


def test_text_from_outside_the_folder_is_told(finger, tmp_path, attach):
    (tmp_path / "rig").mkdir()
    (tmp_path / "other.xml").write_text(
        '<mujoco><custom><text name="a" data="b"/></custom></mujoco>'
    )
    for inside, file in ((False, "../other.xml"), (True, "own.xml")):
        (tmp_path / "rig" / "own.xml").write_text((tmp_path / "other.xml").read_text())
        path = tmp_path / "rig" / "finger.xml"
        include = f'<include file="{file}"/>'
        path.write_text(finger.read_text().replace("<worldbody>", f"{include}<worldbody>", 1))
        status, shown, out = attach(path, "flex*")
        said = f"{out} holds the text of {tmp_path / 'other.xml'}, which {path} includes from out"
        assert (status, said in " ".join(shown.split())) == (0, not inside)


@pytest.mark.parametrize(("beside", "read"), [(False, 0.001), (True, 0.003)])
def test_an_include_in_an_include_is_sought_where_mujoco_seeks_it(
    finger, tmp_path, attach, beside, read
):
    step = '<mujoco><option timestep="{}"/></mujoco>'
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "first.xml").write_text('<mujoco><include file="step.xml"/></mujoco>')
    (tmp_path / "parts" / "step.xml").write_text(step.format(0.001))
    if beside:
        (tmp_path / "step.xml").write_text(step.format(0.003))
    include = '<include file="parts/first.xml"/><worldbody>'
    finger.write_text(finger.read_text().replace("<worldbody>", include, 1))
    status, _, out = attach(finger, "flex*")
    assert status == 0
    assert mujoco.MjModel.from_xml_path(str(out)).opt.timestep == read


def test_a_tendon_stiffer_than_the_step_carries_is_named_with_what_it_carries(finger, attach):
    largest = largest_stiffness(mujoco.MjModel.from_xml_path(str(finger)), "flexor")
    for stiffness, warned in ((0.9 * largest, False), (1.1 * largest, True)):
        given = ["--axial-stiffness", str(stiffness)]
        status, shown, out = attach(finger, "flexor", "extensor", more=given)
        out.unlink()
        said = [line for line in shown.splitlines() if "EA above the" in line]
        assert (status, bool(said)) == (0, warned)
        assert not warned or f"flexor ({stiffness:.4g} N" in said[0]


def test_the_input_end_is_shown_and_written(finger, attach):
    _, _, one = attach(finger, "flexor", out="one.xml")
    status, shown, both = attach(one, "*", out="both.xml", more=["--input-end", "last"])
    assert status == 0
    rows = {row.split()[1]: row for row in shown.splitlines() if row.startswith("│")}
    assert "first, d" in rows["flexor"], "it keeps the sheath that it had"
    assert "last, c" in rows["extensor"]
    assert not {"first", "last"} & set(rows["limp"].split())
    configs = {p.name: p.config for p in mujoco.MjSpec.from_file(str(both)).plugins}
    assert configs["extensor_sheath"]["input_end"] == "last"
    assert "input_end" not in configs["flexor_sheath"]


@pytest.mark.parametrize("doctype", ["", "<!DOCTYPE mujoco [<!ENTITY e 'x'>]>\n"])
def test_comments_around_the_model_and_its_includes_stay(finger, tmp_path, attach, doctype):
    text = finger.read_text()
    included = "<!-- of the part --><mujoco><!-- in it --><custom/></mujoco><!-- end of it -->"
    (tmp_path / "part.xml").write_text(included)
    inside = text.replace("</mujoco>", '<include file="part.xml"/></mujoco>')
    declared = '<?xml version="1.0"?>\n' + doctype
    finger.write_text(f"{declared}<!-- licence --><!-- top -->\n{inside}\n<!-- the end -->\n")
    status, _, out = attach(finger, "flexor")
    assert status == 0
    written = out.read_text()
    said = ("licence", "top", "of the part", "in it", "end of it", "the end")
    places = [written.index(f"<!-- {comment} -->") for comment in said]
    assert places == sorted(places)
    assert written.index("<mujoco") > places[1]
    assert written.index("</mujoco>") < places[-1]


def test_a_name_under_which_mujoco_reads_no_mjcf_is_refused(finger, tmp_path, attach, capsys):
    for name in ("new", "new.mjb", "new.XML"):
        assert attach(finger, "flexor", out=name)[0] == 2
        assert "choose a name that ends in .xml" in " ".join(capsys.readouterr().err.split())
    assert [path.name for path in tmp_path.iterdir()] == ["finger.xml"]
