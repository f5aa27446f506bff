import mujoco
import numpy as np
import pytest

from tendon_mj import add_cable_drive, add_friction
from tendon_mj.errors import InvalidValueError, TendonError
from tendon_mj.lab.finger import lasting, press, simulate_finger, tap
from tendon_mj.lab.frames import FrameRecorder, check_frames
from tendon_mj.lab.motion import frictionless, record_frames
from tendon_mj.models import Bench, build_bench, load_model
from tendon_mj.show.render.offscreen import without_tendons
from tests.refusals import refusing
from tests.rigs import compiled, lever, rope


@pytest.fixture(scope="module")
def model():
    return build_bench(Bench(guides=4)).compile()


def wind_in(time):
    return [0.002 * time]


def test_a_cable_that_is_not_drawn_has_tensions_and_no_path():
    joint = '<joint name="j" type="slide" axis="0 0 1"/><geom size=".1"/>'
    spec = mujoco.MjSpec.from_string(
        f"<mujoco><worldbody><body>{joint}</body></worldbody>"
        '<actuator><position joint="j" kp="50"/></actuator></mujoco>'
    )
    model = add_cable_drive(spec, "*", radius=1.0, bend=1.0, friction=0.1).compile()
    frames = record_frames(model, lambda time: [0.1], duration=0.2, fps=10)
    (cable,) = frames.cables.values()
    assert np.isnan(cable.points).all()
    assert np.isfinite(cable.tensions).all()
    assert not frames.drawn


def test_a_frame_shows_its_own_time_and_the_sensors_tensions(model):
    frames = record_frames(model, wind_in, duration=0.5, fps=20)
    assert frames.time == pytest.approx(np.arange(10) / 20)
    cable = frames.cables["sheath"]
    assert cable.points.shape == (10, 6, 3)
    assert cable.tensions.shape == (10, 5)
    data = mujoco.MjData(model)
    for _ in range(900):  # to the last frame, at 0.45 s
        data.ctrl[:] = wind_in(data.time)
        mujoco.mj_step(model, data)
    data.ctrl[:] = wind_in(data.time)
    mujoco.mj_forward(model, data)
    shown = [data.sensor(name).data[0] for name in ("input_tension", "output_tension")]
    assert cable.tensions[-1, [0, -1]] == pytest.approx(shown, rel=1e-9)


@pytest.mark.parametrize(
    ("change", "facts"),
    [
        ({"duration": 0.0}, ["duration = 0.0 [s]"]),
        ({"duration": 1e12}, ["1e+12 [s]", "GB of memory"]),
        ({"fps": float("nan")}, ["fps = nan [1/s]"]),
        ({"drive": lambda time: [0.0, 0.0]}, ["(2,)", "(1,)"]),
    ],
)
def test_arguments_out_of_range_are_refused_by_name(model, change, facts):
    with refusing(InvalidValueError, *facts):
        record_frames(model, **{"drive": wind_in, "duration": 1.0} | change)


def test_frames_may_take_2_gb(model):
    numbers = mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_PHYSICS) + model.nu
    numbers += model.nsensordata + 4 * model.nwrap
    check_frames(model, 1.8e9 / (8 * numbers), fps=1.0)
    with refusing(InvalidValueError, "2.2 GB"):
        check_frames(model, 2.2e9 / (8 * numbers), fps=1.0)


@pytest.mark.filterwarnings("ignore")
def test_an_unstable_simulation_is_named_with_its_time(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # MuJoCo writes its log where it runs
    model = compiled(lever('<motor name="m" joint="j"/>'))
    with refusing(TendonError, "unstable before"):
        record_frames(model, lambda time: [1e300], duration=1.0)


def test_only_the_sites_on_the_path_are_hidden():
    """A path names sites, geoms and pulleys by numbers of three kinds."""
    text = rope(
        "a; b .6 0 0; beside",
        "c; d 0 0 .1",
        "a drum@ b /2 c d",
        body='pos=".8 0 0"',
        joint='type="slide"',
        world='<replicate count="20" offset="0 0 1"><geom size=".1"/></replicate>'
        '<geom name="drum" type="cylinder" size=".05 .1" pos=".3 0 0" euler="90 0 0"/>',
        actuator='<motor tendon="t" gear="-1"/>',
    )
    spec = mujoco.MjSpec.from_string(text)
    add_friction(spec, "t", friction=0.1)
    model = spec.compile()
    assert (model.wrap_objid >= model.nsite).any(), "the number of a geom is that of no site"
    assert (model.wrap_objid < 0).any(), "that of a pulley neither"
    bare = without_tendons(model)
    hidden = {model.site(k).name for k in range(model.nsite) if bare.site_rgba[k, 3] == 0.0}
    assert hidden == {"a", "b", "c", "d"}


def test_frames_of_a_replay_change_no_reading_and_show_its_poses():
    model = load_model("finger")
    plain, recorder = simulate_finger(tap(), model), FrameRecorder(fps=50)
    recorded = simulate_finger(tap(), model, recorder=recorder)
    for column, values in plain.columns.items():
        np.testing.assert_array_equal(recorded.columns[column], values)
    frames = recorder.frames()
    assert frames.time == pytest.approx(np.arange(150) / 50)
    cable = frames.cables["flexor_sheath"]
    sampled = np.searchsorted(plain.time, frames.time - 1e-9)  # every second sample is a frame's
    for end, column in ((0, "flexor_input_tension_N"), (-1, "flexor_output_tension_N")):
        assert cable.tensions[:, end] == pytest.approx(plain.columns[column][sampled], rel=1e-9)


def test_the_contact_force_of_a_frame_is_what_the_touch_sensor_feels():
    model, recorder = load_model("finger"), FrameRecorder(fps=50)
    simulate_finger(lasting(press(), 4.0), model, recorder=recorder)
    frames = recorder.frames()
    felt = frames.readings[:, model.sensor("tip_force").adr[0]]
    assert felt.max() > 0.5
    for reading, rows in zip(felt, frames.contacts, strict=True):
        pushed = np.linalg.norm(rows[:, 3:], axis=1).max() if len(rows) else 0.0
        assert (pushed > 0.0) == (reading > 0.0), "no arrow of a link that feels nothing"
        assert pushed >= reading - 1e-9  # a touch sensor leaves out what is tangential
    pressed = frames.contacts[int(felt.argmax())]
    assert pressed[0, 3] < 0.0, "the object is pushed towards the palm"


def test_the_frictionless_twin_loses_no_tension(model):
    assert frictionless(model).keys() == {"sheath.friction"}
    frames = record_frames(model, wind_in, duration=0.3, fps=20, parameters=frictionless(model))
    assert np.ptp(frames.cables["sheath"].tensions, axis=1).max() < 1e-9


def test_a_drawn_cable_goes_around_its_pulley_and_leaves_gaps_between_branches():
    spec = mujoco.MjSpec.from_string(
        """<mujoco><worldbody>
          <geom name="drum" type="cylinder" pos="0 0 1" euler="90 0 0" size="0.1 0.03"/>
          <site name="a" pos="-0.1 0 0.4"/><site name="b" pos="0.1 0 0.4"/>
          <site name="c" pos="0.5 0 0"/><site name="d" pos="0.5 0 0.4"/>
          <site name="side" pos="0 0 1.15"/>
        </worldbody><tendon><spatial name="rope">
          <site site="a"/><geom geom="drum" sidesite="side"/><site site="b"/>
          <pulley divisor="2"/><site site="c"/><site site="d"/>
        </spatial></tendon></mujoco>"""
    )
    spec.add_actuator(name="pull", trntype=mujoco.mjtTrn.mjTRN_TENDON, target="rope").set_to_motor()
    add_friction(spec, "rope", friction=0.2)
    frames = record_frames(spec.compile(), lambda _: [-20.0], duration=0.1, fps=10)
    (cable,) = frames.cables.values()
    spans = np.linalg.norm(np.diff(cable.points[-1], axis=0), axis=1)
    gap = np.isnan(cable.tensions[-1])
    assert spans[~gap] == pytest.approx([0.6, 0.2, 0.6, 0.4], abs=1e-9)
    assert gap.sum() == 1
    assert (cable.points[-1][[1, 2], 2] > 0.99).all()
