"""A sheath beside or in a `<replicate>`: it loads where MuJoCo can copy it, else it is refused."""

import mujoco
import pytest

from tendon_mj import add_friction
from tendon_mj.cli import main
from tendon_mj.errors import TendonError
from tendon_mj.models import load_model
from tendon_mj.plugin import sheaths
from tests.refusals import refusing
from tests.rigs import simulated

LINK = """<body pos=".1 0 -.02"><joint name="j" axis="0 1 0"/><geom size=".01"/>
<site name="c" pos=".05 0 .03"/></body>"""
BESIDE = (
    '<site name="a"/><site name="b" pos=".1 0 0"/>'
    + LINK
    + '<replicate count="2" offset="0 1 0"><geom size=".1"/></replicate>'
)
AROUND = (
    '<replicate count="3" offset="0 1 0" sep="-"><body><site name="a"/><site name="b"'
    + f' pos=".1 0 0"/>{LINK}</body></replicate>'
)
SHEATH = """<extension><plugin plugin="tendon_mj.sheath"><instance name="s"><config key="tendon"
value="t"/><config key="friction" value="0.2"/></instance></plugin></extension>"""
ON_TENDON = 'objtype="tendon" objname="t"'


def arm(world, sensor=None):
    """An arm in MJCF, with a sheath where it has a sensor of one."""
    shown = f'<sensor><plugin name="e" plugin="tendon_mj.sheath" instance="s" {sensor}/></sensor>'
    return f"""<mujoco>{"" if sensor is None else SHEATH}<worldbody>{world}</worldbody>
    <tendon><spatial name="t"><site site="a"/><site site="b"/><site site="c"/></spatial></tendon>
    <actuator><motor name="m" tendon="t"/></actuator>{"" if sensor is None else shown}</mujoco>"""


@pytest.mark.parametrize("world", [BESIDE, AROUND], ids=["beside", "around"])
def test_attach_writes_what_mujoco_can_read(world, tmp_path):
    path, out = tmp_path / "arm.xml", tmp_path / "new.xml"
    path.write_text(arm(world))
    arguments = ["attach", str(path), "--tendon", "*", "--friction", "0.2", "--out", str(out)]
    assert main(arguments) == 0
    assert len(sheaths(load_model(str(out)))) == (1 if world is BESIDE else 3)
    assert {p.name for p in tmp_path.iterdir()} == {"arm.xml", "new.xml"}


COPIED = "is on tendon 't', which a <replicate> copies"
DRUM = {'<geom size=".1"/>': '<geom name="drum" size=".1"/>'}
ON_DRUM = {'<site site="c"/>': '<geom geom="drum"/><site site="c"/>'}
X = {'<geom size=".1"/>': '<body name="x"/><site name="x"/>'}
UNNAMED = {'name="e" plugin="tendon_mj.sheath"': 'name="e"'}  # as MuJoCo writes it


@pytest.mark.parametrize(
    ("world", "sensor", "changes", "fact"),
    [
        (BESIDE, "", {}, "has no object"),
        (AROUND, "", {}, "has no object"),
        (AROUND, ON_TENDON, {}, COPIED),
        (BESIDE, ON_TENDON, DRUM | ON_DRUM, COPIED),
        *[
            (BESIDE, f'objtype="{kind}" objname="x"', X | UNNAMED, "'x', which a <replicate>")
            for kind in ("site", "body", "xbody")
        ],
    ],
)
def test_what_mujoco_would_crash_over_is_refused_by_name(world, sensor, changes, fact, tmp_path):
    text = arm(world, sensor)
    for old, new in changes.items():
        text = text.replace(old, new)
    (tmp_path / "arm.xml").write_text(text)
    with refusing(TendonError, "arm.xml", "sensor 'e'", fact):
        load_model(str(tmp_path / "arm.xml"))


def test_text_that_only_mujoco_can_read_is_refused_beside_a_replicate(tmp_path):
    text = arm(BESIDE, "").replace("<mujoco>", '<mujoco model="a & b">')
    (tmp_path / "arm.xml").write_text(text)
    with refusing(TendonError, "arm.xml", "<replicate>"):
        load_model(str(tmp_path / "arm.xml"))


def test_it_is_found_behind_an_include_and_in_a_model_of_the_model(tmp_path):
    (tmp_path / "many.xml").write_text(
        "<mujoco><worldbody><replicate count='2'><geom size='1'/></replicate></worldbody></mujoco>"
    )
    plain = BESIDE.partition("<replicate")[0]
    child = arm(plain, "").replace("<mujoco>", '<mujoco><include file="many.xml"/>')
    (tmp_path / "child.xml").write_text(child)
    (tmp_path / "main.xml").write_text(
        '<mujoco><asset><model name="c" file="child.xml"/></asset></mujoco>'
    )
    for name in ("child.xml", "main.xml"):
        with refusing(TendonError, "child.xml", "sensor 'e'"):
            load_model(str(tmp_path / name))


def test_a_sheath_beside_a_replicate_loads_where_its_sensor_has_the_tendon(tmp_path):
    path = tmp_path / "arm.xml"
    path.write_text(arm(BESIDE, ON_TENDON))
    model = load_model(str(path))
    data = simulated(model, 1, ctrl=-1.0)
    assert data.sensor("e").data[0] == 1.0 > data.sensor("e").data[1] > 0.0


def test_the_copies_of_a_tendon_have_friction_each_and_come_back_from_text():
    spec = mujoco.MjSpec.from_string(arm(AROUND))
    add_friction(spec, "t-*", friction=0.2, sensors=("tension",))
    model = mujoco.MjModel.from_xml_string(spec.to_xml())
    assert {sheath.tendon for sheath in sheaths(model).values()} == {"t-0", "t-1", "t-2"}
