"""Laws of a rig's sensors: plain as they come; late, smooth, scaled, drifting as they are told."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from tendon_mj.errors import InvalidValueError
from tendon_mj.lab.replay import Adjustable, Readout, replay_recording
from tendon_mj.lab.replay.readout import low_pass, make_clock, sense_of
from tests.lab.recorded import recorded
from tests.refusals import refusing
from tests.rigs import lever

TIME = 3.0 + np.linspace(0.0, 2.0, 101)
CLOCK = make_clock(TIME, longest=0.005)
GRID = CLOCK.time - CLOCK.start


def wave(time):
    return np.sin(4.0 * time) - 0.3


def slider(size="", user="", command=""):
    """A servo that takes a slide where it is told, and a sensor that sees it."""
    return mujoco.MjModel.from_xml_string(
        lever(
            f"<position name='servo' joint='slide' kp='200' {command}/>",
            f"<jointpos name='place' joint='slide' {user}/><jointvel name='speed' joint='slide'/>",
            joint='name="slide" type="slide" damping="1"',
            geom='size="0.1" mass="0.1"',
            rest=size,
        )
    )


def test_offset_and_drift_of_a_sensor_are_in_its_unit():
    parameters = Adjustable(slider()).parameters()
    units = {name: parameters[name].unit for name in ("place.offset", "speed.offset")}
    assert units == {"place.offset": "m", "speed.offset": "m/s"}
    units = {name: parameters[name].unit for name in ("place.drift", "speed.drift")}
    assert units == {"place.drift": "m/s", "speed.drift": "m/s²"}


def slide_recording(**known):
    time = np.arange(0.0, 1.0, 0.01)
    return recorded(
        time,
        {"command_m": ("servo", 0.1 * np.sin(6.0 * time))},
        {"place_m": "place"},
        "slider",
        known={name.replace("__", "."): value for name, value in known.items()},
    )


def placed(model=None, **known):
    return replay_recording(slide_recording(**known), model or slider()).columns["place_m"]


def test_a_time_that_is_a_millionth_of_a_step_off_is_on_the_grid():
    late, later = (make_clock([0.0, 1.0, 2.0 + off, 3.0], 1.0).places[2] for off in (7e-7, 1.3e-6))
    assert (late, later) == (2.0, 2.0 + 1.3e-6)


def test_a_plain_sensor_changes_no_bit():
    series = wave(GRID)
    np.testing.assert_array_equal(Readout().of(series, CLOCK, TIME), CLOCK.sample(series))


def test_scale_then_drift_then_offset():
    read = Readout(scale=2.0, offset=0.5, drift=0.1).of(wave(GRID), CLOCK, TIME)
    np.testing.assert_allclose(
        read, 2.0 * wave(TIME - 3.0) + 0.1 * (TIME - TIME[0]) + 0.5, atol=1e-12
    )


@pytest.mark.parametrize("delay", [0.005, 0.013, 0.4])
def test_a_delay_shows_what_was_and_before_the_first_sample_nothing_moved(delay):
    read = Readout(delay=delay).of(wave(GRID), CLOCK, TIME)
    was = np.maximum(0.0, TIME - TIME[0] - delay)
    np.testing.assert_allclose(read, wave(was), atol=16.0 / 8.0 * CLOCK.timestep**2)


@pytest.mark.parametrize("lag", [1e-9, 0.004, 0.1, 50.0])
def test_a_lag_solves_its_equation_exactly_for_what_is_linear(lag):
    """lag y' = x − y for x = a t from rest: y = a (t − lag (1 − e^{−t/lag}))."""
    smooth = low_pass(3.0 * GRID, CLOCK.timestep, lag)
    exact = 3.0 * (GRID + lag * np.expm1(-GRID / lag))
    np.testing.assert_allclose(smooth, exact, rtol=1e-9, atol=1e-12)


# behind a gear

STROKE = np.interp(TIME - TIME[0], [0.0, 0.4, 0.8, 1.4, 2.0], [0.0, 0.0, 3.0, 3.0, -1.0])
LOAD = np.full(GRID.size, 8.0)


def geared(rest_in=-1.0, rest_out=-1.0, stroke=STROKE, load=LOAD, begin=None):
    sense = sense_of(TIME, stroke, begin)
    gear = Readout(efficiency=0.5, rest_in=rest_in, rest_out=rest_out)
    return gear.of(load, CLOCK, TIME, sense)


@pytest.mark.parametrize(
    ("noise", "slow", "moves"),
    [(0.01, 0.035, False), (0.01, 0.045, True), (0.05, 0.09, False), (0.05, 0.14, True)],
)
def test_a_drive_moves_from_four_noises_or_a_tenth_of_its_largest_speed_on(noise, slow, moves):
    """Of speeds in units of the fastest; the noise of one is √2 σ/(2 dt)."""
    time = 0.02 * np.arange(2000)
    place = np.interp(time, [0.0, 4.0, 40.0], [0.0, 4.0, 4.0 + 36.0 * slow])
    place += np.random.default_rng(1).normal(0.0, 0.04 * noise / np.sqrt(2.0), 2000)
    assert (sense_of(time, place).now[500::2].mean() > 0.5) == moves


@pytest.mark.parametrize("noise", [0.0, 1e-3])
def test_a_gear_reads_more_winding_in_and_less_paying_out(noise):
    jitter = np.random.default_rng(1).normal(0.0, noise, TIME.size)
    read = geared(stroke=STROKE + jitter)
    np.testing.assert_allclose(read[22:38], 16.0)
    np.testing.assert_allclose(read[72:98], 4.0)
    np.testing.assert_allclose(read[:18], 4.0)  # at rest it holds


def test_at_rest_a_gear_shows_what_its_friction_leaves():
    after_in, before_any = slice(42, 68), slice(0, 18)
    for rest, reading in ((1.0, 16.0), (-1.0, 4.0), (0.0, 8.0)):
        np.testing.assert_allclose(geared(rest_in=rest)[after_in], reading)
        np.testing.assert_allclose(geared(rest_out=rest)[before_any], reading)
    np.testing.assert_allclose(geared(rest_out=1.0)[after_in], 4.0)
    np.testing.assert_allclose(geared(stroke=-STROKE, rest_out=0.0)[after_in], 8.0)


@pytest.mark.parametrize(("begin", "reading"), [(-1.0, 16.0), (-1e-5, 8.0), (0.0, 8.0), (1.0, 8.0)])
def test_settling_is_a_motion_before_the_first_sample(begin, reading):
    jitter = np.random.default_rng(1).normal(0.0, 1e-5, TIME.size)
    read = geared(rest_in=1.0, rest_out=0.0, stroke=STROKE + jitter, begin=begin)
    np.testing.assert_allclose(read[:18], reading)


def test_a_force_of_the_other_sign_drives_where_the_first_resists():
    np.testing.assert_allclose(geared(load=-LOAD), -(LOAD[0] ** 2) / geared())


def test_where_a_drive_turns_a_gear_shows_what_was_measured_as_far_as_its_loss_explains_it():
    """The motor turns after a rest of 30 samples, of which those beside a motion are uncertain."""
    sense, gear = sense_of(TIME, STROKE), Readout(efficiency=0.5, rest_in=0.0)
    plain = gear.of(LOAD, CLOCK, TIME, sense)
    for measured, shown in ((7.0, 7.0), (99.0, 16.0), (-1.0, 4.0)):
        read = gear.of(LOAD, CLOCK, TIME, sense, np.full(TIME.size, measured))
        np.testing.assert_allclose(read[sense.turns], shown)
        np.testing.assert_array_equal(read[~sense.turns], plain[~sense.turns])
    np.testing.assert_allclose(plain[48:62], 8.0)
    assert not sense.turns[np.r_[:36, 48:62, 76:100]].any()


# in MJCF


def test_user_data_of_five_zeros_or_too_few_is_a_plain_sensor():
    plain = placed()
    for model in (
        slider("<size nuser_sensor='5'/>"),
        slider("<size nuser_sensor='3'/>", "user='9 9 9'"),
        slider("", "user='1 0 0 0 0'"),
        slider("", "", "user='0 0'"),
        slider("", "", "user='9'"),
    ):
        np.testing.assert_array_equal(placed(model), plain)


def test_user_data_acts_as_the_parameters_do():
    model = slider("", "user='2 0.5 0.03 0.1 0.2 77'", "user='0.5 0.1'")
    sensor = {"scale": 2.0, "offset": 0.5, "delay": 0.03, "lag": 0.1, "drift": 0.2}
    given = {f"place__{n}": value for n, value in sensor.items()}
    command = {"servo__command_scale": 0.5, "servo__command_offset": 0.1}
    stored = placed(model)
    np.testing.assert_array_equal(stored, placed(**given, **command))
    late = placed(slider("", "", "user='0.5 0.1 0.03'"))
    np.testing.assert_array_equal(late, placed(**command, servo__command_delay=0.03))
    assert np.abs(stored - placed()).max() > 0.1
    values = Adjustable(model).parameters()
    assert {n: values[f"place.{n}"].value for n in sensor} == sensor
    assert values["speed.scale"].value == 1.0
    assert values["servo.command_offset"].value == 0.1


def test_a_delay_that_looks_ahead_is_refused_wherever_it_stands():
    with refusing(InvalidValueError, "place.delay = -0.1"):
        placed(slider("", "user='1 0 -0.1 0 0'"))
    with refusing(InvalidValueError, "servo.command_delay = -0.1"):
        placed(slider("", "", "user='1 0 -0.1'"))
    with refusing(InvalidValueError, "place.lag = -0.1"):
        placed(place__lag=-0.1)


# of the model


def test_every_parameter_set_to_what_it_is_changes_no_bit():
    values = {name: p.value for name, p in Adjustable(slider()).parameters().items()}
    known = {name.replace(".", "__"): value for name, value in values.items()}
    np.testing.assert_array_equal(placed(**known), placed())


def test_what_is_set_is_read_back():
    rig = Adjustable(slider())
    for name, parameter in rig.parameters().items():
        rig.set({name: parameter.value + 0.25})
    for name, parameter in Adjustable(slider()).parameters().items():
        assert rig.parameters()[name].value == parameter.value + 0.25, name


def test_gravity_pulls_along_its_axis():
    still = {"servo__kp": 200.0, "gravity__z": 0.0}
    along = placed(**{**still, "gravity__z": 10.0})
    across = placed(**still, gravity__y=10.0)
    np.testing.assert_array_equal(across, placed(**still))
    assert np.abs(along - across).max() > 1e-3
