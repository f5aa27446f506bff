"""The command that writes a model with friction."""

import mujoco
import pytest

from tendon_mj import largest_stiffness
from tendon_mj.cli import console, main
from tendon_mj.plugin import sheaths
from tests.rigs import FINGER, LIMP


@pytest.fixture
def finger(tmp_path):
    path = tmp_path / "finger.xml"
    path.write_text(FINGER.format(more=LIMP))
    return path


def test_a_model_with_friction_is_written_and_its_tendons_are_shown(finger, tmp_path, monkeypatch):
    monkeypatch.setattr(console, "width", 200)
    out = tmp_path / "new.xml"
    arguments = ["attach", str(finger), "--tendon", "flex*", "extensor", "--friction", "0.15"]
    with console.capture() as capture:
        assert main([*arguments, "--out", str(out)]) == 0
    shown = capture.get()
    for word in ("flexor", "extensor_sheath", "its spring", "e^(-μφ)", f"wrote {out}"):
        assert word in shown
    model = mujoco.MjModel.from_xml_path(str(out))
    assert {s.tendon for s in sheaths(model).values()} == {"flexor", "extensor"}


def test_what_is_left_out_is_said_with_the_reason(finger, tmp_path, monkeypatch):
    monkeypatch.setattr(console, "width", 200)
    arguments = ["attach", str(finger), "--tendon", "*", "--friction", "0.15"]
    with console.capture() as capture:
        assert main([*arguments, "--out", str(tmp_path / "new.xml")]) == 0
    assert "left as they are: 'limp': has no stiffness to take over" in capture.get()
    assert "left as it was" in capture.get()


BROKEN = FINGER.format(more="").replace('site="f"', 'site="nowhere"')


@pytest.mark.parametrize(
    ("text", "tendon", "said"),
    [
        (None, "flexr", "did you mean 'flexor'"),
        (None, "limp", "'limp' has no stiffness to take over"),
        (None, "lim*", "none of the tendons that 'lim*' means"),
        (BROKEN, "flexor", "nowhere"),
        ("<mujoco><nothing/></mujoco>", "flexor", "Schema violation"),
        ("no XML", "flexor", "XML"),
    ],
)
def test_a_refusal_is_one_line_and_writes_nothing(finger, tmp_path, capsys, text, tendon, said):
    if text is not None:
        finger.write_text(text)
    out = tmp_path / "new.xml"
    arguments = ["attach", str(finger), "--tendon", tendon, "--friction", "0.15"]
    assert main([*arguments, "--out", str(out)]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1
    assert not out.exists()


def test_text_from_outside_the_folder_is_told(finger, tmp_path, capsys):
    (tmp_path / "rig").mkdir()
    (tmp_path / "other.xml").write_text(
        '<mujoco><custom><text name="a" data="b"/></custom></mujoco>'
    )
    for inside, file in ((False, "../other.xml"), (True, "own.xml")):
        (tmp_path / "rig" / "own.xml").write_text((tmp_path / "other.xml").read_text())
        path, out = tmp_path / "rig" / "finger.xml", tmp_path / "new.xml"
        include = f'<include file="{file}"/>'
        path.write_text(finger.read_text().replace("<worldbody>", f"{include}<worldbody>", 1))
        arguments = ["attach", str(path), "--tendon", "flex*", "--friction", "0.1"]
        with console.capture() as capture:
            assert main([*arguments, "--out", str(out)]) == 0
        said = f"{out} holds the text of {tmp_path / 'other.xml'}, which {path} includes from out"
        assert (said in capture.get()) != inside


@pytest.mark.parametrize(("beside", "read"), [(False, 0.001), (True, 0.003)])
def test_an_include_in_an_include_is_sought_where_mujoco_seeks_it(finger, tmp_path, beside, read):
    step = '<mujoco><option timestep="{}"/></mujoco>'
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "first.xml").write_text('<mujoco><include file="step.xml"/></mujoco>')
    (tmp_path / "parts" / "step.xml").write_text(step.format(0.001))
    if beside:
        (tmp_path / "step.xml").write_text(step.format(0.003))
    include = '<include file="parts/first.xml"/><worldbody>'
    finger.write_text(finger.read_text().replace("<worldbody>", include, 1))
    out = tmp_path / "new.xml"
    arguments = ["attach", str(finger), "--tendon", "flex*", "--friction", "0.1"]
    assert main([*arguments, "--out", str(out)]) == 0
    assert mujoco.MjModel.from_xml_path(str(out)).opt.timestep == read


@pytest.mark.parametrize("declared", [b"", b'<?xml version="1.0" encoding="ISO-8859-1"?>\n'])
def test_text_that_is_not_utf_8_is_refused_by_its_row(finger, tmp_path, capsys, declared):
    finger.write_bytes(declared + b"<!-- by J\xf6rg -->\n" + finger.read_bytes())
    arguments = ["attach", str(finger), "--tendon", "flexor", "--friction", "0.15"]
    assert main([*arguments, "--out", str(tmp_path / "new.xml")]) == 2
    row = 2 if declared else 1
    said = f"{finger}, row {row}: byte 0xf6 is not UTF-8; save the file as UTF-8"
    assert said in capsys.readouterr().err
    assert not (tmp_path / "new.xml").exists()


def test_a_motor_without_a_name_is_told_by_its_number(finger, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(console, "width", 200)
    text = finger.read_text()
    motors = '<actuator><motor joint="mcp"/><motor tendon="flexor"/></actuator></mujoco>'
    finger.write_text(text.replace("</mujoco>", motors))
    out = tmp_path / "new.xml"
    arguments = ["attach", str(finger), "--tendon", "flexor", "--friction", "0.1"]
    assert main([*arguments, "--pretension", "1", "--out", str(out)]) == 2
    error = capsys.readouterr().err
    assert "'flexor' is driven by actuator 1, which has no name, whose force" in error
    with console.capture() as capture:
        assert main([*arguments, "--out", str(out)]) == 0
    assert "actuator 1" in capture.get()


def test_a_tendon_stiffer_than_the_step_carries_is_named_with_what_it_carries(finger, tmp_path):
    arguments = ["attach", str(finger), "--tendon", "flexor", "extensor", "--friction", "0.15"]
    out = ["--out", str(tmp_path / "new.xml")]
    largest = largest_stiffness(mujoco.MjModel.from_xml_path(str(finger)), "flexor")
    for stiffness, warned in ((0.9 * largest, False), (1.1 * largest, True)):
        (tmp_path / "new.xml").unlink(missing_ok=True)
        with console.capture() as capture:
            assert main([*arguments, "--axial-stiffness", str(stiffness), *out]) == 0
        said = [line for line in capture.get().splitlines() if "EA above the" in line]
        assert bool(said) == warned
        assert not warned or f"flexor ({stiffness:.4g} N" in said[0]


SPRUNG = """<mujoco><option timestep="0.005"/><worldbody><site name="a" pos="-.2 0 .06"/>
  <site name="b" pos="-.07 0 .0355"/><body><joint axis="0 1 0" range="-60 60"/>
  <geom type="capsule" fromto="0 0 0 .2 0 0" size=".01" mass=".16"/>
  <site name="c" pos=".05 0 .024"/><site name="d" pos=".1 0 .02"/></body></worldbody>
  <tendon><spatial name="t" stiffness="600"><site site="a"/><site site="b"/><site site="c"/>
    <site site="d"/></spatial></tendon>
  <actuator><position tendon="t" kp="1400"/></actuator></mujoco>"""


@pytest.mark.parametrize(("friction", "said"), [("0.5", False), ("5", True)])
def test_a_pull_that_friction_makes_too_stiff_for_the_step_is_named(tmp_path, friction, said):
    (tmp_path / "m.xml").write_text(SPRUNG)
    given = ["attach", str(tmp_path / "m.xml"), "--tendon", "t", "--friction", friction]
    with console.capture() as capture:
        assert main([*given, "--out", str(tmp_path / "new.xml")]) == 0
    lines = [line for line in capture.get().splitlines() if "friction magnifies" in line]
    assert bool(lines) == said
    assert not said or "t (up to" in lines[0]
    assert not said or "N/m of 2000 N/m, where" in lines[0]


def test_the_input_end_is_shown_and_written(finger, tmp_path, monkeypatch):
    monkeypatch.setattr(console, "width", 200)
    one, both = tmp_path / "one.xml", tmp_path / "both.xml"
    given = ["--friction", "0.15", "--tendon"]
    assert main(["attach", str(finger), *given, "flexor", "--out", str(one)]) == 0
    with console.capture() as capture:
        last = ["--input-end", "last", "--out", str(both)]
        assert main(["attach", str(one), *given, "*", *last]) == 0
    rows = {row.split()[1]: row for row in capture.get().splitlines() if row.startswith("│")}
    assert "first, d" in rows["flexor"], "it keeps the sheath that it had"
    assert "last, c" in rows["extensor"]
    assert not {"first", "last"} & set(rows["limp"].split())
    configs = {p.name: p.config for p in mujoco.MjSpec.from_file(str(both)).plugins}
    assert configs["extensor_sheath"]["input_end"] == "last"
    assert "input_end" not in configs["flexor_sheath"]


def test_no_file_that_a_model_in_the_model_includes_is_written_over(tmp_path, capsys):
    part = '<mujocoinclude><body name="c"><geom size=".1"/></body></mujocoinclude>'
    (tmp_path / "part.xml").write_text(part)
    (tmp_path / "child.xml").write_text(
        '<mujoco><worldbody><include file="part.xml"/></worldbody></mujoco>'
    )
    (tmp_path / "main.xml").write_text("""
    <mujoco>
      <asset><model name="child" file="child.xml"/></asset>
      <worldbody>
        <attach model="child" body="c" prefix="x_"/>
        <site name="a"/><site name="b" pos=".1 0 0"/>
        <body><joint/><geom size=".1"/><site name="c" pos=".1 .1 0"/></body>
      </worldbody>
      <tendon><spatial name="t">
        <site site="a"/><site site="b"/><site site="c"/>
      </spatial></tendon>
      <actuator><motor tendon="t"/></actuator>
    </mujoco>""")
    arguments = ["attach", str(tmp_path / "main.xml"), "--tendon", "t", "--friction", "0.1"]
    for name in ("part.xml", "child.xml", "main.xml"):
        assert main([*arguments, "--out", str(tmp_path / name)]) == 2
        assert f"{name} is a file that" in capsys.readouterr().err
    assert (tmp_path / "part.xml").read_text() == part
    assert main([*arguments, "--out", str(tmp_path / "other.xml")]) == 0


@pytest.mark.parametrize("doctype", ["", "<!DOCTYPE mujoco [<!ENTITY e 'x'>]>\n"])
def test_comments_around_the_model_and_its_includes_stay(finger, tmp_path, doctype):
    text = finger.read_text()
    included = "<!-- of the part --><mujoco><!-- in it --><custom/></mujoco><!-- end of it -->"
    (tmp_path / "part.xml").write_text(included)
    inside = text.replace("</mujoco>", '<include file="part.xml"/></mujoco>')
    declared = '<?xml version="1.0"?>\n' + doctype
    finger.write_text(f"{declared}<!-- licence --><!-- top -->\n{inside}\n<!-- the end -->\n")
    arguments = ["attach", str(finger), "--tendon", "flexor", "--friction", "0.15"]
    assert main([*arguments, "--out", str(tmp_path / "new.xml")]) == 0
    written = (tmp_path / "new.xml").read_text()
    said = ("licence", "top", "of the part", "in it", "end of it", "the end")
    places = [written.index(f"<!-- {comment} -->") for comment in said]
    assert places == sorted(places)
    assert written.index("<mujoco") > places[1]
    assert written.index("</mujoco>") < places[-1]


def test_a_name_under_which_mujoco_reads_no_mjcf_is_refused(finger, tmp_path, capsys):
    arguments = ["attach", str(finger), "--tendon", "flexor", "--friction", "0.15"]
    for name in ("new", "new.mjb", "new.XML"):
        assert main([*arguments, "--out", str(tmp_path / name)]) == 2
        assert "choose a name that ends in .xml" in " ".join(capsys.readouterr().err.split())
    assert [path.name for path in tmp_path.iterdir()] == ["finger.xml"]


def test_two_includes_that_are_links_to_one_file_are_both_in_the_model(finger, tmp_path):
    (tmp_path / "part.xml").write_text('<mujoco><worldbody><geom size="1"/></worldbody></mujoco>')
    (tmp_path / "link.xml").symlink_to("part.xml")
    both = '<include file="part.xml"/><include file="link.xml"/>'
    finger.write_text(finger.read_text().replace("<worldbody>", f"{both}<worldbody>", 1))
    arguments = ["attach", str(finger), "--tendon", "flexor", "--friction", "0.15"]
    assert main([*arguments, "--out", str(tmp_path / "new.xml")]) == 0
    models = [mujoco.MjModel.from_xml_path(str(tmp_path / f"{n}.xml")) for n in ("finger", "new")]
    assert models[0].ngeom == models[1].ngeom
