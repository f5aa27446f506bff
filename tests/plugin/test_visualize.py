"""The plugin draws its tendons where the model says between which tensions its colours lie."""

import mujoco
import numpy as np
import pytest
from matplotlib import colormaps

import tendon_mj
from tendon_mj.errors import EngineError, InvalidValueError
from tendon_mj.plugin import TENSION_SCALE
from tendon_mj.plugin.sheath_plugin.visualize import SHADED, SLIPPING, VIRIDIS
from tendon_mj.show.render.offscreen import make_context
from tests.refusals import refusing
from tests.rigs import pulled_xml, rope

LOW, HIGH = 0.0, 42.0
TENDON = mujoco.mjtObj.mjOBJ_TENDON.value
CAPSULE, SPHERE = mujoco.mjtGeom.mjGEOM_CAPSULE.value, mujoco.mjtGeom.mjGEOM_SPHERE.value
WIDTH = 0.01
VISUAL = """<visual><headlight ambient=".3 .3 .3" diffuse=".6 .6 .6" specular=".5 .5 .5"/>
  <global offwidth="400" offheight="200"/></visual><default><site size=".001"/></default>"""
WORLD = """<light pos="0 -1 1" dir="0 1 -1"/>
  <camera name="c" pos="0.5 -1.2 0.05" xyaxes="1 0 0 0 0 1"/>"""
PULLED = pulled_xml(0.1, WIDTH, VISUAL, WORLD, 'size=".001" mass="1"')


def pulled(scale=(LOW, HIGH), friction=0.0):
    """A tendon over one guide, whose motor's control is the input tension."""
    spec = mujoco.MjSpec.from_string(PULLED)
    tendon_mj.add_friction(spec, "t", friction=friction)
    if scale:
        tendon_mj.show_tension(spec, *scale)
    model = spec.compile()
    return model, mujoco.MjData(model)


def scene_of(model, data, most=1000, option=None):
    scene, camera = mujoco.MjvScene(model, most), mujoco.MjvCamera()
    option = option or mujoco.MjvOption()
    kinds = mujoco.mjtCatBit.mjCAT_ALL.value
    mujoco.mjv_updateScene(model, data, option, None, camera, kinds, scene)
    return scene


def drawn(scene, kind=CAPSULE):
    """Geoms of a scene that the plugin drew."""
    geoms = scene.geoms[: scene.ngeom]
    return [g for g in geoms if g.objtype == TENDON and g.emission > 1.0 and g.type == kind]


def colour(geom):
    return geom.emission * geom.rgba[:3]


def test_the_table_is_viridis_and_lights_hardly_act_on_it():
    shown = np.array(colormaps["viridis"](np.arange(256)))[:, :3]
    assert np.abs(VIRIDIS - shown).max() < 0.5 / 255 + 1e-9
    assert SHADED < 0.5 / 255


@pytest.mark.parametrize("tension", np.linspace(1.0, 41.0, 21))
def test_each_span_has_the_colour_of_its_tension(tension):
    model, data = pulled(friction=0.3)
    data.ctrl[0] = tension
    for _ in range(3):
        mujoco.mj_step(model, data)
    spans = drawn(scene_of(model, data))
    view = tendon_mj.view_sheath(model, data, "t")
    for geom, known in zip(spans, view.tension, strict=True):
        expected = colormaps["viridis"]((known - LOW) / (HIGH - LOW))[:3]
        np.testing.assert_allclose(colour(geom), expected, atol=1 / 255)
        assert WIDTH < geom.size[0] < 1.5 * WIDTH  # it covers MuJoCo's own
    ends = [np.array(g.pos + s * g.size[2] * g.mat[:, 2]) for g in spans for s in (-1, 1)]
    np.testing.assert_allclose(ends, data.wrap_xpos.reshape(-1, 3)[[0, 1, 1, 2]], atol=1e-6)


def test_the_picture_can_be_read_off_a_colour_bar_at_twenty_tensions():
    model, data = pulled()
    try:
        context = make_context(400, 200)
    except EngineError as error:
        pytest.skip(f"nothing can be drawn here: {error}")
    graphics = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
    mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, graphics)
    scene, camera, option = mujoco.MjvScene(model, 100), mujoco.MjvCamera(), mujoco.MjvOption()
    camera.type, camera.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED, 0
    place, image = mujoco.MjrRect(0, 0, 400, 200), np.empty((200, 400, 3), np.uint8)
    worst = 0
    for tension in np.linspace(1.0, 41.0, 21):
        data.ctrl[0] = tension
        mujoco.mj_step(model, data)
        kinds = mujoco.mjtCatBit.mjCAT_ALL.value
        mujoco.mjv_updateScene(model, data, option, None, camera, kinds, scene)
        mujoco.mjr_render(place, scene, graphics)
        mujoco.mjr_readPixels(image, None, place, graphics)
        known = tendon_mj.view_sheath(model, data, "t").tension[0]
        expected = 255.0 * np.array(colormaps["viridis"]((known - LOW) / (HIGH - LOW))[:3])
        middle = drawn(scene)[0].pos - scene.camera[0].pos
        right = np.cross(scene.camera[0].forward, scene.camera[0].up)
        depth = middle @ scene.camera[0].forward
        zoom = 100 * scene.camera[0].frustum_near / scene.camera[0].frustum_top / depth
        column, row = 200 + zoom * (middle @ right), 100 + zoom * (middle @ scene.camera[0].up)
        seen = image[round(row), round(column)].astype(float)
        worst = max(worst, np.abs(seen - expected).max())
    graphics.free()
    context.free()
    assert worst <= 4.0


def test_a_guide_is_marked_while_the_tendon_slips_over_it():
    model, data = pulled(friction=0.3)
    seen = set()
    for k in range(600):
        data.ctrl[0] = 20.0 * min(1.0, k / 300)
        mujoco.mj_step(model, data)
        slips = tendon_mj.view_sheath(model, data, "t").slip[0] != 0.0
        marks = drawn(scene_of(model, data), SPHERE)
        assert len(marks) == int(slips)
        seen.add(bool(slips))
        for mark in marks:
            np.testing.assert_allclose(colour(mark), SLIPPING, atol=1e-6)
            np.testing.assert_allclose(mark.pos, [0.5, 0.0, 0.1], atol=1e-6)
            width = drawn(scene_of(model, data))[0].size[0]
            assert width < mark.size[0] <= 1.3001 * width, "it shows, and leaves the tendon visible"
    assert seen == {True, False}


def test_a_guide_is_not_marked_where_no_tension_presses_the_tendon_on_it():
    """A slack tendon is drawn over its guides by motions that nobody sees, and by rounding."""
    text = rope(
        "a -.02 -.05 -.05; b -.04 0 0",
        "c .012 0 .02; d .009 0 .06",
        law={"friction": 0.2},
        body='pos="-.05 0 .02"',
        joint='axis="0 1 0" stiffness=".05" damping=".005"',
        geom='size=".01" mass=".1"',
        option='gravity="0 0 0"',
        actuator='<motor tendon="t" gear="-1"/>',
    )
    model = tendon_mj.show_tension(mujoco.MjSpec.from_string(text), LOW, HIGH).compile()
    data, marks, slips = mujoco.MjData(model), {True: 0, False: 0}, 0
    for k in range(2000):
        data.ctrl[0] = 5.0 * np.sin(np.pi * min(1.0, k / 500)) ** 2
        mujoco.mj_step(model, data)
        view = tendon_mj.view_sheath(model, data, "s")
        is_slack = bool(view.tension.max() < 1e-20)
        marks[is_slack] += len(drawn(scene_of(model, data), SPHERE))
        slips += is_slack and bool(view.slip.any())
    assert marks[True] == 0 < slips
    assert marks[False] > 100


@pytest.mark.parametrize("room", [0, 1, 2, 3])
def test_nothing_is_written_beyond_a_scene_s_capacity(room, capfd):
    model, data = pulled()
    data.ctrl[0] = 10.0
    mujoco.mj_step(model, data)
    most = scene_of(pulled(None)[0], data).ngeom + room
    scene = scene_of(model, data, most)
    assert scene.ngeom <= scene.maxgeom == most
    assert scene.status == (1 if room < 2 else 0)


@pytest.mark.parametrize("hide", ["flag", "group", "invisible", *range(20)])
def test_what_mujoco_does_not_draw_or_no_evaluation_has_filled_is_not_drawn(hide):
    model, data = pulled()
    assert not drawn(scene_of(model, data))
    mujoco.mj_step(model, data)
    assert drawn(scene_of(model, data))
    option = mujoco.MjvOption()
    if hide == "flag":
        option.flags[mujoco.mjtVisFlag.mjVIS_TENDON] = 0
    elif hide == "group":
        option.tendongroup[model.tendon_group[0]] = 0
    elif hide == "invisible":
        model.tendon_rgba[0, 3] = 0.0
    else:
        values = [np.nan, 0.0, 1.0, -1.0, 1e300]
        data.plugin_state[:] = np.random.default_rng(hide).choice(values, data.plugin_state.size)
    assert not drawn(scene_of(model, data, option=option))


def test_drawing_changes_nothing_that_is_simulated():
    model, data = pulled(friction=0.3)
    other = mujoco.MjData(model)
    bare, third = pulled(None, friction=0.3)
    for k in range(300):
        for each in (data, other, third):
            each.ctrl[0] = 20.0 * np.sin(0.02 * k) ** 2
        mujoco.mj_step(model, data)
        scene_of(model, data)
        mujoco.mj_step(model, other)
        mujoco.mj_step(bare, third)
        for kind in (CAPSULE, SPHERE):
            assert not drawn(scene_of(bare, third), kind)  # without the numeric
    for each in (other, third):
        assert np.array_equal(data.qpos, each.qpos)
        assert np.array_equal(data.sensordata, each.sensordata)
    assert np.array_equal(data.plugin_state, other.plugin_state)


def test_an_arc_and_a_pulley_are_drawn_along_mujoco_s_path():
    text = rope(
        "a; b .6 0 0; up .3 0 .2; d .9 0 .3",
        "c",
        "a drum@up b /2 d c",
        tendon='width=".001"',
        body='pos="1 0 0"',
        joint='type="slide" stiffness="2000" damping="50"',
        geom='size=".01" mass="1"',
        world='<geom name="drum" type="cylinder" size=".05 .1" pos=".3 0 0" euler="90 0 0"/>',
        actuator='<motor tendon="t" gear="-1"/>',
    )
    spec = mujoco.MjSpec.from_string(text)
    tendon_mj.add_friction(spec, "t", friction=0.1, arc_guides=3)
    model = tendon_mj.show_tension(spec, 0.0, 20.0).compile()
    data = mujoco.MjData(model)
    data.ctrl[0] = 10.0
    for _ in range(5):
        mujoco.mj_step(model, data)
    spans = drawn(scene_of(model, data))
    length = sum(2.0 * g.size[2] for g in spans)
    path = data.wrap_xpos.reshape(-1, 3)[: data.ten_wrapnum[0]]
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    of_pulley = list(data.wrap_obj.ravel()[: data.ten_wrapnum[0]]).index(-2)
    expected = steps.sum() - steps[of_pulley - 1 : of_pulley + 1].sum()
    assert length == pytest.approx(expected, rel=1e-5)  # floats, and no line across the pulley
    assert len(spans) == 2 + 4 + 1


def test_limits_can_be_changed_in_a_spec_and_in_a_model():
    spec = mujoco.MjSpec.from_string(PULLED)
    tendon_mj.add_friction(spec, "t", friction=0.0)
    with pytest.raises(InvalidValueError, match="the lower one first"):
        tendon_mj.show_tension(spec, 1.0, 0.0)
    for wrong in ([3.0, 3.0], [5.0, 1.0], [1.0], [0.0, 1.0, 2.0], [0.0, np.inf]):
        other = spec.copy()
        other.add_numeric(name=TENSION_SCALE, size=len(wrong), data=wrong)
        with refusing(ValueError, TENSION_SCALE, "two tensions [N]"):
            other.compile()
    tendon_mj.show_tension(spec, 0.0, 1.0)
    model = tendon_mj.show_tension(spec, 0.0, 20.0).compile()
    assert list(model.numeric(TENSION_SCALE).data) == [0.0, 20.0]
    data = mujoco.MjData(model)
    data.ctrl[0] = 10.0
    mujoco.mj_step(model, data)
    before = colour(drawn(scene_of(model, data))[0])
    model.numeric(TENSION_SCALE).data[:] = 0.0, 10.0
    after = colour(drawn(scene_of(model, data))[0])
    np.testing.assert_allclose(before, VIRIDIS[128], atol=2 / 255)
    np.testing.assert_allclose(after, VIRIDIS[255], atol=2 / 255)
