"""A model with sheaths as a file: what it says, and that all else stays as written."""

import math

import mujoco
import numpy as np
import pytest

from tendon_mj import add_friction, remove_friction
from tendon_mj.attach import attach_friction
from tendon_mj.attach.mjcf import write_sheaths
from tendon_mj.cli import console, main
from tendon_mj.errors import TendonError
from tendon_mj.models import load_spec
from tendon_mj.plugin import sheaths
from tests.refusals import refusing
from tests.rigs import rope, simulated

HAND = """
<mujoco>
  <!-- a comment -->
  <worldbody>
    <site name="a"/><site name="b" pos="0.1234567890123 0 0"/><site name="c" pos=".2 .1 0"/>
    <body pos="0.2 0 0">
      <joint name="knuckle" axis="0 0 1" range="-60 60"/><geom size="0.01" pos="0.05 0 0"/>
      <site name="d" pos="0.03 0.01 0"/>
    </body>
  </worldbody>
  <tendon>
    <spatial name="flexor" stiffness="2000" springlength="0.2"><site site="a"/><site site="b"/>
      <site site="d"/></spatial>
    <spatial stiffness="20"><site site="a"/><site site="b"/><site site="c"/></spatial>
    <spatial name="loose"><site site="a"/><site site="d"/></spatial>
    <fixed name="sum"><joint joint="knuckle" coef="1"/></fixed>
  </tendon>
  <sensor><jointpos name="angle" joint="knuckle"/></sensor>
</mujoco>
"""
TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


def attached_to(path, *arguments, **options):
    return attach_friction(load_spec(str(path)), path, *arguments, **options)


def printed(path, tendon, friction):
    """Lines that the command prints."""
    given = ["--tendon", tendon, "--friction", str(friction), "--out", str(path) + ".new.xml"]
    with console.capture() as capture:
        assert main(["attach", str(path), *given]) == 0
    return capture.get().splitlines()


@pytest.fixture
def hand(tmp_path):
    path = tmp_path / "hand.xml"
    path.write_text(HAND)
    return path


@pytest.fixture
def spread(tmp_path):
    """A model in several files: one that is included, and a mesh in a folder of its own."""
    (tmp_path / "in" / "shapes").mkdir(parents=True)
    (tmp_path / "in" / "shapes" / "solid.obj").write_text(TETRAHEDRON)
    (tmp_path / "in" / "tendons.xml").write_text(
        f"<mujocoinclude><tendon>{HAND.split('<tendon>')[1].split('</tendon>')[0]}</tendon>"
        "</mujocoinclude>"
    )
    text = HAND.split("<tendon>")[0] + '<include file="tendons.xml"/>' + HAND.split("</tendon>")[1]
    text = text.replace("<worldbody>", '<worldbody><geom type="mesh" mesh="solid"/>')
    extra = '<compiler meshdir="shapes"/><asset><mesh name="solid" file="solid.obj"/></asset>'
    path = tmp_path / "in" / "hand.xml"
    path.write_text(text.replace("<worldbody>", f"{extra}<worldbody>", 1))
    return path


def test_the_file_has_the_sheaths_and_every_other_number_as_written(hand, tmp_path):
    out = tmp_path / "new.xml"
    attached_to(hand, ["flexor"], out, friction=0.15)
    assert "0.1234567890123" in out.read_text()
    assert "<!-- a comment -->" in out.read_text()
    model, plain = mujoco.MjModel.from_xml_path(str(out)), mujoco.MjModel.from_xml_string(HAND)
    assert {s.tendon for s in sheaths(model).values()} == {"flexor"}
    data = simulated(model)
    pull = 2000.0 * (plain.tendon_length0[0] - 0.2)
    assert data.sensor("flexor_input_tension").data == pytest.approx(pull, rel=1e-9)
    assert model.sensor("angle").adr == 0, "the model's own sensors stay where they are"


def test_friction_can_be_taken_off_a_written_model_again(hand, tmp_path):
    out = tmp_path / "new.xml"
    with refusing(TendonError, "'loose'", "stiffness"):
        attached_to(hand, ["flexor", "loose"], out, friction=0.15)
    attached_to(hand, "*", out, friction=0.15)
    again = remove_friction(mujoco.MjSpec.from_file(str(out)), "*").compile()
    plain = mujoco.MjModel.from_xml_string(HAND)
    for field in ("tendon_stiffness", "tendon_lengthspring", "qpos0", "site_pos", "tendon_length0"):
        np.testing.assert_array_equal(getattr(again, field), getattr(plain, field), err_msg=field)
    assert (again.nplugin, again.nsensor, again.ntext) == (0, 1, 0)


def test_each_tendon_that_is_meant_has_a_row_of_what_was_done_to_it(hand, tmp_path):
    attached = attached_to(hand, "*", tmp_path / "new.xml", friction=0.15)
    rows = {row.tendon: row for row in attached.rows}
    assert set(rows) == {"flexor", "tendon_1", "loose", "sum"}
    assert rows["flexor"].done == "sheath 'flexor_sheath', its spring as elasticity"
    assert rows["tendon_1"].done == "named, sheath 'tendon_1_sheath', its spring as elasticity"
    assert rows["loose"].done == rows["sum"].done == "left as it was"
    assert [rows[t].drives for t in rows] == ["its spring", "its spring", "nothing", "nothing"]
    length = mujoco.MjModel.from_xml_string(HAND).tendon_length0[1]
    assert rows["tendon_1"].axial_stiffness == pytest.approx(20.0 * length)
    bend = math.atan2(0.1, 0.2 - 0.1234567890123)
    one = rows["tendon_1"]
    assert [one.bend, one.least_bend, one.most_bend] == pytest.approx([bend] * 3)
    assert one.transmission == one.least_transmission == pytest.approx(math.exp(-0.15 * bend))
    one = rows["flexor"]
    assert one.least_bend <= one.bend < one.most_bend
    assert one.least_transmission < one.transmission < 1.0


def test_the_bend_over_the_motion_decides_which_tendon_loses_most(hand, tmp_path):
    hand.write_text(HAND.replace('name="c" pos=".2 .1 0"', 'name="c" pos=".2 .01 0"'))
    last = printed(hand, "*", 0.5)[-1]
    rows = attached_to(hand, "*", tmp_path / "new.xml", friction=0.5).rows
    most = max(rows, key=lambda row: row.most_bend)
    assert most.bend < max(row.bend for row in rows), "not the most bent one at qpos0"
    assert most.tendon in last
    for part in (1.0 - most.transmission, 1.0 - most.least_transmission):
        assert f"{part:.0%}" in last
    for bend in (most.least_bend, most.most_bend):
        assert f"{bend:.2f}" in last


def test_friction_that_joints_do_not_feel_is_no_loss(tmp_path):
    path = tmp_path / "beyond.xml"
    path.write_text(rope("a 0 0 .1", "b .1 0 .1; c .2 0 0"))
    lines = printed(path, "t", 0.5)
    assert any("no effect on 't'" in line for line in lines)
    assert "%" not in lines[-1]


def test_a_limit_that_pulls_is_the_drive(hand, tmp_path):
    hand.write_text(HAND.replace('name="loose"', 'name="loose" range="0 .25"'))
    rows = attached_to(hand, "loose", tmp_path / "new.xml", friction=0.1).rows
    assert [row.drives for row in rows] == ["its limit"]


def test_bend_that_is_not_drawn_is_bend(hand, tmp_path):
    out = tmp_path / "new.xml"
    plain, more = (
        attached_to(hand, "f*", out, friction=0.1, extra_bend=bend).rows[0] for bend in (0.0, 2.0)
    )
    assert more.bend - plain.bend == pytest.approx(2.0)


def test_a_sheath_that_was_there_is_left_with_its_own_friction(hand, tmp_path):
    first, second = tmp_path / "first.xml", tmp_path / "second.xml"
    attached_to(hand, "flexor", first, friction=0.5)
    attached = attached_to(first, "*", second, friction=0.1)
    flexor, other, *_ = attached.rows
    assert (flexor.friction, flexor.done) == (0.5, "left in sheath 'flexor_sheath'")
    assert (other.friction, other.sheath) == (0.1, "tendon_1_sheath")
    assert len(sheaths(mujoco.MjModel.from_xml_path(str(second)))) == 2


@pytest.mark.parametrize("folder", ["in", "elsewhere", "in/below"])
def test_includes_and_assets_are_found_from_where_it_is_written(spread, tmp_path, folder):
    (tmp_path / folder).mkdir(exist_ok=True)
    out = tmp_path / folder / "new.xml"
    attached_to(spread, "*", out, friction=0.1)
    model = mujoco.MjModel.from_xml_path(str(out))
    assert (model.nmesh, len(sheaths(model))) == (1, 2)


def test_no_file_that_the_model_is_made_of_is_written_over(spread, tmp_path):
    files = {path: path.read_text() for path in spread.parent.rglob("*.*")}
    link = tmp_path / "link.xml"
    link.symlink_to(spread)
    for out in [*files, link]:
        facts = (out, spread) if out.suffix == ".xml" else (out,)
        with refusing(TendonError, *facts):
            attached_to(spread, "*", out, friction=0.1)
    assert files == {path: path.read_text() for path in spread.parent.rglob("*.*")}


def test_what_cannot_be_written_leaves_what_was_there(hand, tmp_path):
    out = tmp_path / "new.xml"
    out.write_text("mine")
    for place in (tmp_path, tmp_path / "nowhere" / "new.xml"):
        with refusing(TendonError, str(place)):
            attached_to(hand, "flexor", place, friction=0.1)
    with refusing(TendonError, "'flexer'"):
        attached_to(hand, ["flexer"], out, friction=0.1)
    spec = add_friction(mujoco.MjSpec.from_file(str(hand)), "flexor", friction=0.1)
    spec.body("world").add_site(name="more")
    with refusing(TendonError, str(out), "mjModel"):
        write_sheaths(hand, spec, out)
    assert out.read_text() == "mine"
    assert hand.read_text() == HAND
    assert sorted(path.name for path in tmp_path.iterdir()) == ["hand.xml", "new.xml"]
    attached_to(hand, "flexor", out, friction=0.1)
    assert out.read_text() != "mine"


def test_a_tendon_that_is_not_in_the_text_is_refused_with_the_remedy(hand, tmp_path):
    parent = tmp_path / "parent.xml"
    parent.write_text(
        '<mujoco><asset><model name="hand" file="hand.xml"/></asset><worldbody><frame>'
        '<attach model="hand" prefix="left_"/></frame></worldbody></mujoco>'
    )
    with refusing(TendonError, "'left_flexor'", "MjSpec.to_xml"):
        attached_to(parent, "*flexor", tmp_path / "new.xml", friction=0.1)


# the rope passes the slide's body square to its axis: it moves the rope only away from qpos0
SQUARE = """
<mujoco><worldbody><site name="a" pos="-.1 0 0"/>
  <body><joint name="shift" type="slide" axis="0 0 1"{range}/><geom size=".01"/>
    <site name="b"/></body><site name="c" pos=".1 0 0"/></worldbody>
  <tendon><spatial name="rope"><site site="a"/><site site="b"/><site site="c"/></spatial></tendon>
  <actuator><motor name="{name}" tendon="rope" {ends}/></actuator></mujoco>"""


def square(tmp_path, joint="", name="pull", ends='ctrlrange="-9 0"', friction=0.1):
    (tmp_path / "square.xml").write_text(SQUARE.format(range=joint, name=name, ends=ends))
    return attached_to(tmp_path / "square.xml", "rope", tmp_path / "n.xml", friction=friction)


def test_a_slide_without_range_that_moves_the_tendon_away_from_qpos0_only_is_named(tmp_path):
    assert square(tmp_path, ' range="-.1 .1"').limits == ()
    assert square(tmp_path).limits == ("held as in qpos0, as they have no range: shift",)


@pytest.mark.parametrize(
    ("ends", "said"),
    [
        ("", True),
        ('gear="-2"', True),
        ('ctrlrange="-9 0"', False),
        ('gear="-1" ctrlrange="0 9"', False),
        ('forcerange="-9 0"', False),
    ],
)
def test_a_motor_that_no_range_keeps_from_pushing_is_named_without_a_warning(tmp_path, ends, said):
    messages = square(tmp_path, name="m", ends=ends).said
    assert len(messages) == said
    assert not said or "forcerange keeps m on rope from pushing" in messages[0]
