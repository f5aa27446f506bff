"""A sheath beside or in a `<replicate>`."""

import mujoco
import pytest

from tendon_mj import add_friction
from tendon_mj.cli import main
from tendon_mj.models import load_model
from tendon_mj.plugin import sheaths
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
