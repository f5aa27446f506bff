"""A model with a sheath of every kind that MuJoCo Warp supports, and steps of it."""

import mujoco
import numpy as np
import pytest

from tendon_mj.plugin import segment_tensions, sheaths
from tests.rigs import config

WHY = "the extra `warp` is not installed, or too old: pip install --upgrade 'tendon-mj[warp]'"
mjw = pytest.importorskip("mujoco_warp", reason=WHY)
tw = pytest.importorskip("tendon_mj.warp", reason=WHY, exc_type=ImportError)

VERSION = tuple(int(part) for part in mjw.__version__.split(".")[:2])
agrees = pytest.mark.skipif(
    VERSION < (3, 15), reason="MuJoCo Warp before 3.15 moves this model otherwise than MuJoCo"
)

ROOT = """
  <body name="{k}_upper" pos="0 {y} 0">
    <joint name="{k}_one" axis="0 1 0" damping=".02" stiffness=".5"/>
    <geom type="capsule" fromto="0 0 0 .2 0 0" size=".01" mass=".2" contype="0" conaffinity="0"/>
    <geom name="{k}_drum" type="{shape}" size=".015 .02" euler="90 0 0" pos=".2 0 0" contype="0"
      conaffinity="0"/>
    <site name="{k}_c" pos=".1 0 .03"/><site name="{k}_d" pos=".17 .01 .03"/>
    <body pos=".2 0 0"><joint name="{k}_two" axis="0 1 0" damping=".01" stiffness=".3"/>
      <geom type="capsule" fromto="0 0 0 .15 0 0" size=".01" mass=".1" contype="0" conaffinity="0"/>
      <site name="{k}_e" pos=".06 0 .02"/><site name="{k}_f" pos=".1 .01 .01"/>
    </body></body>
  <site name="{k}_a" pos="-.2 {y} .05"/><site name="{k}_b" pos="-.02 {y} .05"/>
"""
OVER_SITES = "abcdef"
AROUND = ("a", "b", "d", None, "e")  # None: the drum
WOUND = {"axial_stiffness": 2e3, "pretension": 5.0, "friction": 0.2}
# of each finger: shape of its drum, its path, what pulls it, attributes of its sheath
FINGERS = {
    "reel": ("sphere", OVER_SITES, "", WOUND | {"constant_friction": 0.5}),
    "spools": ("sphere", AROUND, "", WOUND | {"static_friction": 0.3}),
    "drum": (
        "cylinder",
        AROUND,
        '<motor tendon="drum" gear="2" ctrlrange="-9 0"/>',
        {"friction": 0.15, "arc_guides": 3, "axial_stiffness": 1e4},
    ),
    "last": (
        "cylinder",
        AROUND,
        '<muscle tendon="last" force="30" lengthrange=".2 .5" ctrlrange="0 1"/>',
        {"friction": 0.2, "static_friction": 0.25, "input_end": "last", "axial_stiffness": 1e4},
    ),
    "bent": (
        "sphere",
        OVER_SITES,
        '<position tendon="bent" kp="200" kv="2" ctrlrange=".3 .4"/>',
        {"friction": 0.1, "extra_bend": 1.0, "inner_guides": 2, "axial_stiffness": 1e4},
    ),
    "spring": ("sphere", AROUND, "", {"friction": 0.3, "axial_stiffness": 1e4}),
    "cable": ("sphere", OVER_SITES, "", {"friction": 0.3, "spring": "cable"}),
    "limit": ("sphere", OVER_SITES, "", {"friction": 0.3, "axial_stiffness": 1e4}),
    "equal": ("sphere", AROUND, "", {"friction": 0.3, "axial_stiffness": 1e4}),
}
OWN = {
    "spring": 'stiffness="60" springlength="0.3" damping="0.4"',
    "cable": 'stiffness="400" springlength="0.48"',
    "limit": 'limited="true" range="0 0.49" solreflimit="0.05 1"',
}
EQUAL = '<equality><tendon tendon1="equal" polycoef="-0.02 0 0 0 0" solref="0.05 1"/></equality>'
CELLS = """<force name="{k}_force" site="{k}_c"/><torque name="{k}_torque" site="{k}_c"/>
  <force name="{k}_force2" site="{k}_e"/><torque name="{k}_torque2" site="{k}_e"/>"""
if VERSION < (3, 14):
    CELLS = ""  # which are refused there
SPOOLS = """
  <body pos="-.3 .2 0"><joint name="reel_joint" axis="0 1 0" stiffness=".02" damping=".01"/>
    <geom size=".03" mass=".3"/></body>
  <body pos=".6 .2 0"><joint name="out_joint" type="slide" axis="0 1 0" stiffness="900"
    damping="1"/><geom size=".03" mass=".3"/></body>
"""
SPOOLED = {
    "reel_joint": "reel_joint",
    "reel_radius": 0.02,
    "output_joint": "out_joint",
    "output_radius": 0.5,
}
DRIVEN = ("drum", "last", "bent", "spring", "limit", "equal")
KINDS = ("input_tension", "tension", "bend_angle", "slip", "reel_displacement", "unsolved")


def fingers_xml(kinds=tuple(FINGERS), integrator="implicitfast", rest="", **changed):
    """A model of fingers of some kinds; ``changed`` attributes belong to all their sheaths."""
    chosen = {k: FINGERS[k] for k in kinds}
    instances, bodies, tendons, actuators, sensors = "", "", "", "", ""
    for y, (k, (shape, path, pulls, law)) in enumerate(chosen.items()):
        law = law | (SPOOLED if k == "spools" else {}) | changed
        counted = sum(point is None for point in path)
        arcs = counted * law.get("arc_guides", 1)
        guides = len(path) - 2 - counted + arcs + law.get("inner_guides", 0)
        text = config(tendon=k, guides=guides, **({"arc_guides": 1} | law))
        instances += f'<instance name="{k}">{text}</instance>'
        for kind in KINDS:
            text = config(tendon=k, sensor=kind)
            instances += f'<instance name="{k}_{kind}">{text}</instance>'
            sensors += f'<plugin name="{k}_{kind}" instance="{k}_{kind}"/>'
        sensors += f'<plugin name="{k}" instance="{k}"/>' + CELLS.format(k=k)
        bodies += ROOT.format(k=k, y=0.1 * y, shape=shape)
        points = "".join(
            f'<geom geom="{k}_drum"/>' if p is None else f'<site site="{k}_{p}"/>' for p in path
        )
        tendons += f'<spatial name="{k}" {OWN.get(k, "")}>{points}</spatial>'
        actuators += pulls
        rest += EQUAL if k == "equal" else ""
        if k == "reel":
            actuators += '<plugin plugin="tendon_mj.sheath" instance="reel" tendon="reel"/>'
    return f"""<mujoco><option timestep="0.001" integrator="{integrator}"/>
      <extension><plugin plugin="tendon_mj.sheath">{instances}</plugin></extension>
      <worldbody>{bodies}{SPOOLS if "spools" in chosen else ""}</worldbody>
      <tendon>{tendons}</tendon><actuator>{actuators}</actuator><sensor>{sensors}</sensor>
      {rest}</mujoco>"""


def fingers(**options):
    return mujoco.MjModel.from_xml_string(fingers_xml(**options))


def controls(model, steps, seed=0):
    """(steps, nu) smooth controls, of a reel a millimetre to and fro."""
    rng = np.random.default_rng(seed)
    low, high = np.where(model.actuator_ctrllimited[:, None], model.actuator_ctrlrange, 1e-3).T
    low = np.where(model.actuator_ctrllimited, low, -1e-3)
    phase, pace = rng.uniform(0, 6, model.nu), rng.uniform(3, 9, model.nu)
    time = model.opt.timestep * np.arange(steps)[:, None]
    wave = 0.5 - 0.5 * np.cos(2 * np.pi * pace * time + phase)
    return (low + (high - low) * wave).astype(np.float32)


def put(model, nworld=1):
    """The model and its data on the device."""
    return tw.put_model(model), tw.make_data(model, nworld)


def step(m, d, control):
    """One step of all worlds with a control of all, or of each."""
    d.ctrl.assign(np.broadcast_to(control, d.ctrl.shape).astype(np.float32))
    mjw.step(m, d)


def tensions(model, data):
    """Tension of every segment of the plugin's sheaths [N]."""
    return np.concatenate([segment_tensions(model, data, k)[1] for k in sheaths(model)])
