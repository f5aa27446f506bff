"""Laws of a description to fill in: it names all that a model has, and is valid once filled in."""

from __future__ import annotations

import re
from pathlib import Path

import mujoco
import numpy as np
import pytest

from tendon_mj import add_cable_drive, load_model, read_recording
from tendon_mj.errors import RecordingError
from tendon_mj.lab.data_check import check_recording
from tendon_mj.lab.recordings.description import Description, parse_toml
from tendon_mj.lab.replay import Adjustable, format_template
from tests.refusals import refusing
from tests.rigs import compiled, lever

MODELS = ["bench", "joint", "finger", "finger_spring"]


def parse_description(text: str, where: str) -> Description:
    return parse_toml(text, where)[0]


@pytest.mark.parametrize("name", MODELS)
def test_every_actuator_and_sensor_of_a_model_is_in_it(name: str) -> None:
    model = load_model(name)
    text = format_template(model, name)
    described = parse_description(text, name)
    actuators = {model.actuator(k).name for k in range(model.nactuator)}
    assert set(described.drive.values()) == actuators
    for k in range(model.nsensor):
        assert repr(model.sensor(k).name)[1:-1] in text
    ones = [model.sensor(k).name for k in range(model.nsensor) if model.sensor_dim[k] == 1]
    assert {m.sensor for m in described.measured.values()} <= set(ones)
    assert all(f'{{ sensor = "{one}" }}' in text for one in ones)


@pytest.mark.parametrize("name", MODELS)
def test_what_it_says_of_parameters_is_what_the_model_has(name: str) -> None:
    """With the comment signs taken off, every line is a value that the model takes."""
    model = load_model(name)
    text = re.sub(r'^# (".*" = )', r"\1", format_template(model, name), flags=re.M)
    described = parse_description(text, name)
    there = Adjustable(model).parameters()
    for parameter, value in described.known.items():
        assert value == pytest.approx(there[parameter].value, rel=1e-3)
    for parameter, guess in described.uncertain.items():
        assert guess.value == pytest.approx(there[parameter].value, rel=1e-3)
        assert [guess.low, guess.high] == pytest.approx(
            [guess.value / 3, 3 * guess.value], rel=1e-3
        )


def test_friction_that_a_model_lacks_is_guessed() -> None:
    motor = lever('<position name="a" joint="j" kp="1"/>', joint='name="j" axis="0 1 0"')
    spec = mujoco.MjSpec.from_string(motor)
    add_cable_drive(spec, "*", radius=0.01, bend=3.0, friction=0.0)
    (guess,) = parse_description(format_template(spec.compile(), "m"), "m").uncertain.values()
    assert (guess.value, guess.low, guess.high) == (0.15, 0.0, 0.45)


@pytest.mark.parametrize("kind", ["motor", "position"])
def test_a_motor_that_bears_a_load_at_rest_begins_with_the_first_drive_value(kind: str) -> None:
    """From a control of 0 it would let go first; without a load nothing is lost by coming to it."""

    def held_by(spring):
        joint = f'name="j" axis="0 1 0" {spring}'
        geom = 'size=".1" pos=".1 0 0"'
        return compiled(lever(f'<{kind} name="a" joint="j"/>', joint=joint, geom=geom))

    held = held_by("")
    assert parse_description(format_template(held, "m"), "m").settle == 0.0
    held.opt.gravity[:] = 0.0
    assert parse_description(format_template(held, "m"), "m").settle == 0.5
    model = held_by('stiffness="1" springref="30"')
    model.opt.gravity[:] = 0.0
    assert parse_description(format_template(model, "m"), "m").settle == 0.0


@pytest.mark.parametrize("name", ["bench", "joint"])
def test_once_it_is_filled_in_a_check_accepts_it(name: str, tmp_path: Path) -> None:
    text = format_template(load_model(name), name)
    described = parse_description(text, name)
    time = np.arange(0.0, 0.5, 0.01)
    columns = [*described.drive, *described.measured]
    rows = [
        ",".join([f"{t:.2f}", *(f"{1e-4 * np.sin(9 * t + k):.9f}" for k in range(len(columns)))])
        for t in time
    ]
    (tmp_path / "r.csv").write_text("\n".join([",".join(["time_s", *columns]), *rows]))
    (tmp_path / "r.toml").write_text(text)
    with refusing(RecordingError, "source"):
        read_recording(tmp_path / "r")
    (tmp_path / "r.toml").write_text(text.replace('source = ""', 'source = "a test"'))
    assert check_recording(read_recording(tmp_path / "r")).simulated is not None


HARD = lever(
    '<velocity name="with &quot;quotes&quot;" joint="a joint"/>'
    '<general name="of a site" site="tip"/><motor joint="a joint"/>',
    '<jointactuatorfrc name="tip_m" joint="a joint"/>'
    '<framepos name="place" objtype="site" objname="tip"/>'
    '<clock name="clock"/><jointpos joint="a joint"/>'
    "<jointpos name='q,1' joint='a joint'/><jointpos name='q_1' joint='a joint'/>",
    joint='name="a joint" type="slide"',
    rest='<worldbody><site name="tip"/></worldbody>',
)


def test_any_name_makes_valid_toml() -> None:
    text = format_template(mujoco.MjModel.from_xml_string(HARD), 'a "model".xml')
    described = parse_description(text, "hard")
    assert described.model == 'a "model".xml'
    assert described.drive == {"with _quotes__m_per_s": 'with "quotes"'}
    assert {c: m.sensor for c, m in described.measured.items()} == {
        "tip_m_of_it_N": "tip_m",
        "q_1_m": "q,1",
        "another_q_1_m": "q_1",
    }
    for said in ('# "of a site_N"', "actuator 2 has no name", "'place' reads 3", "sensor 3 has no"):
        assert said in text
