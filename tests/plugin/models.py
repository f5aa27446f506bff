"""Small models on which the plugin's laws are tested, and how to read them."""

import contextlib

import mujoco
import numpy as np

from tendon_mj.attach import add_friction, add_sites, add_tendon, arc_points
from tendon_mj.plugin import sheaths
from tendon_mj.plugin.sheath_plugin.state import view

SHEATH = """
  <extension>
    <plugin plugin="tendon_mj.sheath"><instance name="sheath">{config}</instance>{views}</plugin>
  </extension>
"""
# Three links in space, a tendon over sites on all of them and on the ground.
ARM = """
<mujoco model="arm">
  <option timestep="{timestep}" integrator="{integrator}" gravity="0 0 -9.81"/>
  <option><flag energy="enable"/></option>
  {extension}
  <default><geom type="box" contype="0" conaffinity="0" mass=".5"/></default>
  <worldbody>
    <site name="ground" pos="-.1 .03 .05"/>
    <body name="upper">
      <joint name="shoulder" axis="0 1 0" damping="{damping}" stiffness="3"/>
      <geom pos=".15 0 0" size=".15 .02 .02"/>
      <site name="one" pos=".1 .02 .05"/><site name="two" pos=".22 -.02 .05"/>
      <body name="lower" pos=".3 0 0">
        <joint name="elbow" axis="0 .8 .6" damping="{damping}" stiffness="2"/>
        <geom pos=".125 0 0" size=".125 .02 .02"/>
        <site name="three" pos=".06 .01 .04"/><site name="four" pos=".18 0 .04"/>
        <body name="hand" pos=".25 0 0">
          <joint name="wrist" axis="0 1 0" damping="{damping}" stiffness="1"/>
          <geom pos=".05 0 0" size=".05 .02 .02" mass=".2"/>
          <site name="tip" pos=".07 0 .03"/>
        </body>
      </body>
    </body>
    {bodies}
  </worldbody>
  <tendon>
    <spatial name="tendon" {elastic}>
      <site site="ground"/><site site="one"/><site site="two"/><site site="three"/>
      <site site="four"/><site site="tip"/>
    </spatial>
  </tendon>
  {rest}
</mujoco>
"""
SPOOLS = """
    <body pos="-.2 0 0"><joint name="reel" axis="0 1 0" stiffness=".02" damping="{damping}"/>
      <geom size=".03 .03 .02" mass=".3"/></body>
    <body pos=".5 .5 0"><joint name="drum" type="slide" axis="0 1 0" stiffness="900"
      damping="{damping}"/><geom type="sphere" size=".03" mass=".3"/></body>
"""
SPOOLED = {
    "reel_joint": "reel",
    "reel_radius": 0.02,
    "output_joint": "drum",
    "output_radius": 0.5,
}
VIEWS = ("input_tension", "output_tension", "tension", "bend_angle", "slip", "friction_work")


def config(**values):
    return "".join(f'<config key="{k}" value="{v}"/>' for k, v in values.items())


def arm_xml(
    timestep=0.0005,
    integrator="Euler",
    damping=0.0,
    spools=False,
    views=(*VIEWS, "unsolved"),
    **values,
):
    """The arm with a sheath; ``values`` are attributes of the plugin."""
    law = {"tendon": "tendon", "axial_stiffness": 500.0, "friction": 0.2, "pretension": 8.0}
    law |= (SPOOLED if spools else {}) | values
    shown = "".join(
        f'<instance name="{v}">{config(tendon="tendon", sensor=v)}</instance>' for v in views
    )
    sensors = "".join(
        f'<plugin name="{v}" plugin="tendon_mj.sheath" instance="{v}"/>' for v in views
    )
    return ARM.format(
        timestep=timestep,
        integrator=integrator,
        damping=damping,
        extension=SHEATH.format(config=config(**law), views=shown),
        bodies=SPOOLS.format(damping=damping) if spools else "",
        elastic="",
        rest=f"<sensor>{sensors}</sensor>",
    )


def arm(**values):
    return mujoco.MjModel.from_xml_string(arm_xml(**values))


def plain_arm(stiffness, springlength, timestep=0.0005, integrator="Euler"):
    """The arm with MuJoCo's own tendon: a spring that does not push."""
    return mujoco.MjModel.from_xml_string(
        ARM.format(
            timestep=timestep,
            integrator=integrator,
            damping=0.0,
            extension="",
            bodies="",
            elastic=f'stiffness="{stiffness!r}" springlength="0 {springlength!r}"',
            rest="",
        )
    )


def fixed_sheaths(sheaths_of, timestep=0.001):
    """Sheaths between fixed ends, each on a reel: dicts of guides, bend, friction, pretension, …

    Their points may be given in place of bend, guides and length.
    """
    spec = mujoco.MjSpec()
    spec.option.timestep = timestep
    for k, law in enumerate(sheaths_of):
        law = dict(law)
        points = law.pop("points", None)
        if points is None:
            points = arc_points(law.pop("length", 0.5), law.pop("bend"), law.pop("guides"))
        add_tendon(spec, f"t{k}", add_sites(spec, f"s{k}", points))
        add_friction(
            spec, f"t{k}", reel=f"reel{k}", **{"name": f"sheath{k}", "axial_stiffness": 20e3} | law
        )
    return spec.compile()


def started(model, seed=None, speed=1.0):
    """Fresh data, moving in a random way where a seed is given."""
    data = mujoco.MjData(model)
    if seed is not None:
        data.qvel[:] = speed * np.random.default_rng(seed).normal(size=model.nv)
    return data


@contextlib.contextmanager
def warnings_of_ours():
    """Messages of our warnings that MuJoCo is given; its own are left out."""
    messages, before = [], mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda m: messages.append(m) if "tendon_mj" in m else None)
    try:
        yield messages
    finally:
        mujoco.set_mju_user_warning(before)


def run(model, data, steps, each=None):
    for k in range(steps):
        if each is not None:
            each(k)
        mujoco.mj_step(model, data)
    return data


def snapshot(model, data):
    """All that MuJoCo calls the state of a simulation."""
    kind = mujoco.mjtState.mjSTATE_INTEGRATION
    state = np.empty(mujoco.mj_stateSize(model, kind))
    mujoco.mj_getState(model, data, state, kind)
    return state


def unsigned(numbers):
    """A state without its signatures, which tell models apart that do the same."""
    return np.where(numbers >= 2.0**52, 0.0, numbers)


def restore(model, data, state):
    mujoco.mj_setState(model, data, state, mujoco.mjtState.mjSTATE_INTEGRATION)


def sheath_view(model, data, sheath="s"):
    """State of a sheath by name, as views on `plugin_state`."""
    return view(data.plugin_state, sheaths(model)[sheath].state)


def unpacked(model, data, sheath="sheath"):
    """Scalars, segments and guides of a sheath, as views on `plugin_state`."""
    return sheath_view(model, data, sheath)[:3]


def tendon_total(model, data, sheath="sheath"):
    """Unstretched length that is stored and wound [m], which nothing may change."""
    scalars, segments, _ = unpacked(model, data, sheath)
    return segments["stored"].sum() + scalars.wound_in + scalars.wound_out


def segment_lengths(model, data):
    """Lengths of the segments of a model's only tendon, from where its sites are."""
    points = data.site_xpos[model.wrap_objid]
    return np.linalg.norm(np.diff(points, axis=0), axis=1)


def elastic_energy(model, data, axial_stiffness):
    """U = Σ EA/2 ε² s over the segments, from the tensions that the sensor shows."""
    strain = data.sensor("tension").data / axial_stiffness
    stored = segment_lengths(model, data) / (1.0 + strain)
    return float(np.sum(0.5 * axial_stiffness * strain**2 * stored))
