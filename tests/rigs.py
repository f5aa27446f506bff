"""Models on which laws are tested, how to write them in a few words, and how to read them.

`rope` and `lever` write MJCF. Models: a finger of two links, the arm (three links in space),
sheaths between fixed ends, a sheath between two prescribed drives, a motor with a servo, every kind
of sheath at once, and models of others in the folder that TENDON_MJ_MODELS names.
"""

import contextlib
import os
from pathlib import Path

import mujoco
import numpy as np
import pytest

from tendon_mj import add_friction, add_servo, add_sites, add_tendon, arc_points
from tendon_mj.plugin import sheaths
from tendon_mj.plugin.sheath_plugin.state import view

NO_CONTACT = '<default><geom contype="0" conaffinity="0"/></default>'
STILL = 'timestep=".001" gravity="0 0 0"'


def numbers(values):
    """Numbers as MJCF has them."""
    return " ".join(map(str, values))


def config(**values):
    """MJCF of an instance's configuration; what is None is left out."""
    return "".join(f'<config key="{k}" value="{v}"/>' for k, v in values.items() if v is not None)


def instance(name, **values):
    return f'<instance name="{name}">{config(**values)}</instance>'


def plugin(*instances, kind="sheath"):
    return f'<plugin plugin="tendon_mj.{kind}">{"".join(instances)}</plugin>'


def sheath(name="s", **values):
    """MJCF of an extension with one sheath."""
    return f"<extension>{plugin(instance(name, **values))}</extension>"


def shown(name="s", more=""):
    """MJCF of a sensor of both ends of a sheath."""
    return f'<plugin plugin="tendon_mj.sheath" instance="{name}" {more}/>'


def sites(places):
    """MJCF of sites from "a 0 0 .1; b", their names and positions."""
    named = (place.split(maxsplit=1) for place in filter(str.strip, places.split(";")))
    return "".join(
        f'<site name="{name}"' + (f' pos="{at[0]}"/>' if at else "/>") for name, *at in named
    )


def route(words):
    """MJCF of a path from "a drum@side b /2 c d": sites, geoms with a side site or without."""
    elements = []
    for word in words.split():
        site, wraps, side = word.partition("@")
        if word[0] == "/":
            elements.append(f'<pulley divisor="{word[1:]}"/>')
        elif wraps:
            elements.append(f'<geom geom="{site}"' + (f' sidesite="{side}"/>' if side else "/>"))
        else:
            elements.append(f'<site site="{site}"/>')
    return "".join(elements)


def spatial(name, words, more=""):
    return f'<spatial name="{name}" {more}>{route(words)}</spatial>'


def rope(
    ground,
    moving,
    words="",
    *,
    name="t",
    tendon="",
    law=None,
    body="",
    joint='name="j" axis="0 1 0"',
    geom='size=".01"',
    link="",
    option="",
    head="",
    world="",
    tendons="",
    actuator='<motor name="pull" tendon="t"/>',
    sensor="",
    rest="",
):
    """MJCF of a tendon from sites on the ground to those on a body that a joint lets move.

    Args:
        ground, moving: sites as `sites` has them.
        words: path as `route` has it; over all sites in turn if not given.
        tendon, body, joint, geom, option: attributes; joints may be whole elements too.
        law: attributes of a sheath ``s`` on the tendon, whose ends the first sensor shows.
        link: a body on that body.
        head, world, tendons, sensor, rest: further elements, by where they go.
    """
    if law is not None:
        head += sheath(tendon=name, **law)
        sensor = shown() + sensor
    words = words or " ".join(place.split()[0] for place in f"{ground}; {moving}".split(";"))
    joints = joint if joint.startswith("<") else f"<joint {joint}/>"
    return f"""<mujoco><option {option}/>{NO_CONTACT}{head}
      <worldbody>{sites(ground)}{world}
        <body {body}>{joints}<geom {geom}/>{sites(moving)}{link}</body></worldbody>
      <tendon>{spatial(name, words, tendon)}{tendons}</tendon>
      <actuator>{actuator}</actuator><sensor>{sensor}</sensor>{rest}</mujoco>"""


def block_and_tackle():
    """MJCF of a load on a rope of two branches, of which only the first bends, by 90°."""
    return rope(
        "a -.3 0 1; b 0 0 1; e .1 0 1",
        "c; d .1 0 0",
        "a b c /2 d e",
        joint='name="j" type="slide" axis="0 0 1" damping="50"',
        geom='size=".05" mass="1"',
        actuator='<motor name="pull" tendon="t" ctrlrange="-40 0"/>',
    )


def pulled_xml(height=0.3, width=0.005, head="", world="", geom='size=".01" mass="1"'):
    """MJCF of a mass on a spring that a motor pulls over a guide; its control is the tension."""
    return rope(
        f"a; b .5 0 {height}",
        "c",
        tendon=f'width="{width}"',
        body='pos="1 0 0"',
        joint='name="j" type="slide" axis="1 0 0" stiffness="2000" damping="50"',
        geom=geom,
        head=head,
        world=world,
        actuator='<motor name="pull" tendon="t" gear="-1"/>',
    )


def lever(actuator="", sensor="", *, joint='name="j"', geom='size=".1"', body="", rest=""):
    """MJCF of a body on a joint without a tendon."""
    return f"""<mujoco>{rest}<worldbody><body {body}><joint {joint}/><geom {geom}/></body>
      </worldbody><actuator>{actuator}</actuator><sensor>{sensor}</sensor></mujoco>"""


def compiled(text):
    return mujoco.MjModel.from_xml_string(text)


def simulated(model, steps=0, *, forward=False, **fields):
    """Data some steps on, with ``fields`` set at the start, evaluated there where asked for."""
    data = mujoco.MjData(model)
    for name, value in fields.items():
        getattr(data, name)[:] = value
    mujoco.mj_step(model, data, steps)
    if forward or not steps:
        mujoco.mj_forward(model, data)
    return data


TWO_LINKS = """
<mujoco><option {option}/>{extension}
  <worldbody>
    <site name="a" pos="-.2 0 .05"/><site name="b" pos="-.02 .01 .05"/><site name="s" pos="0 0 .1"/>
    <site name="b2" pos="-.02 .01 .05"/>
    <geom name="wheel" type="cylinder" size=".03 .05" euler="90 0 0" contype="0" conaffinity="0"/>
    <body><joint name="one" axis="0 1 0" damping=".05" stiffness="2"/>
      <geom type="capsule" fromto="0 0 0 .2 0 0" size=".01" mass=".3"/>
      <site name="c" pos=".14 .01 .03"/><site name="t" pos=".2 0 .06"/>
      <geom name="ball" type="sphere" size=".02" pos=".2 0 0" contype="0" conaffinity="0"/>
      <body pos=".2 0 0"><joint name="two" axis="0 1 0" damping=".03" stiffness="1"/>
        <geom type="capsule" fromto="0 0 0 .15 0 0" size=".01" mass=".2"/>
        <site name="d" pos=".06 0 .02"/><site name="e" pos=".11 .01 .01"/>
      </body></body>
    <body pos="0 1 0"><joint name="reel" axis="0 1 0" damping=".01" armature=".02" stiffness=".1"/>
      <geom size=".03" mass=".3"/></body>
    <body pos="0 2 0"><joint name="drum" type="slide" axis="0 1 0" damping="5" stiffness="900"/>
      <geom size=".03" mass=".3"/></body>
  </worldbody>
  <tendon>{tendon}</tendon><actuator>{actuator}</actuator><sensor>{sensor}</sensor>
</mujoco>
"""


def two_links(words="a b c d", *, tendon="", law=None, actuator="", option='timestep=".001"'):
    """MJCF of two links, pulled by a tendon over bends, and of a reel and a drum beside them.

    A path may go over the sites a, b (b2 is on the same spot), c, d and e, around the cylinder
    ``wheel@s`` of the first joint and the sphere ``ball@t`` of the second.
    """
    return TWO_LINKS.format(
        option=option,
        extension="" if law is None else sheath(tendon="t", **law),
        tendon=spatial("t", words, tendon),
        actuator=actuator,
        sensor="" if law is None else shown(),
    )


# of two joints, with a tendon on either side
FINGER = """
<mujoco>
  <default><geom type="box" size=".1 .02 .02" pos=".1 0 0" contype="0" conaffinity="0"/></default>
  <worldbody>
    <site name="a" pos="-.1 0 .04"/><site name="d" pos="-.1 0 -.04"/>
    <body>
      <joint name="mcp" axis="0 1 0" damping=".002"/><geom/>
      <site name="b" pos=".05 0 .03"/><site name="e" pos=".05 0 -.03"/>
      <body pos=".2 0 0">
        <joint name="pip" axis="0 1 0" damping=".002"/><geom/>
        <site name="c" pos=".05 0 .03"/><site name="f" pos=".05 0 -.03"/>
      </body>
    </body>
  </worldbody>
  <tendon>
    <spatial name="extensor" stiffness="400" springlength="0 .29">
      <site site="a"/><site site="b"/><site site="c"/>
    </spatial>
    <spatial name="flexor" stiffness="300">
      <site site="d"/><site site="e"/><site site="f"/>
    </spatial>
    {more}
  </tendon>
</mujoco>
"""
# A tendon that nothing pulls.
LIMP = '<spatial name="limp"><site site="a"/><site site="e"/><site site="c"/></spatial>'


def finger(more=""):
    """A spec of it, with ``more`` among its tendons."""
    return mujoco.MjSpec.from_string(FINGER.format(more=more))


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
    <spatial name="tendon">
      <site site="ground"/><site site="one"/><site site="two"/><site site="three"/>
      <site site="four"/><site site="tip"/>
    </spatial>
  </tendon>
  <sensor>{sensors}</sensor>
</mujoco>
"""
SPOOLS = """
    <body pos="-.2 0 0"><joint name="reel" axis="0 1 0" stiffness=".02" damping="{damping}"/>
      <geom size=".03 .03 .02" mass=".3"/></body>
    <body pos=".5 .5 0"><joint name="drum" type="slide" axis="0 1 0" stiffness="900"
      damping="{damping}"/><geom type="sphere" size=".03" mass=".3"/></body>
"""
SPOOLED = {"reel_joint": "reel", "reel_radius": 0.02, "output_joint": "drum", "output_radius": 0.5}
VIEWS = ("input_tension", "output_tension", "tension", "bend_angle", "slip", "friction_work")


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
    shown_by = (instance(view, tendon="tendon", sensor=view) for view in views)
    return ARM.format(
        timestep=timestep,
        integrator=integrator,
        damping=damping,
        extension=f"<extension>{plugin(instance('sheath', **law), *shown_by)}</extension>",
        bodies=SPOOLS.format(damping=damping) if spools else "",
        sensors="".join(shown(view, f'name="{view}"') for view in views),
    )


def arm(**values):
    return mujoco.MjModel.from_xml_string(arm_xml(**values))


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


def unpacked(model, data, sheath=None):
    """Scalars, segments and guides of a sheath, the only one, as views on `plugin_state`."""
    return sheath_view(model, data, sheath or next(iter(sheaths(model))))[:3]


def tendon_total(model, data, sheath=None):
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


LENGTH, BEND, GUIDES, EA, PRETENSION = 0.5, 2.0, 8, 20e3, 30.0
ON_DRUM = 1.0 / (1.0 + PRETENSION / EA)  # unstretched length of a metre on a drum [-]
# every effect at once, each to a degree that shows
ALL = {
    "static_friction": 0.25,
    "constant_friction": 0.2,
    "stribeck_friction": 0.05,
    "stribeck_velocity": 0.02,
    "viscous_friction": 2.0,
    "direction_asymmetry": 0.2,
    "friction_gradient": 3.0,
    "load_gradient": 0.01,
    "friction_drift": 0.4,
    "backlash": 2e-4,
    "stiffening": 2.0,
    "creep": 0.3,
    "creep_time": 0.05,
    "sheath_compliance": 1e-6,
    "output_compliance": 1e-6,
    "tendon_mass": 2e-3,
    "extra_bend": 0.3,
    "axial_damping": 1.0,
}
EFFECTS = {name: {name: value} for name, value in ALL.items()} | {
    "stribeck_friction": {"stribeck_friction": 0.05, "stribeck_velocity": 0.02},
    "creep": {"creep": 0.3, "creep_time": 0.05},
}
del EFFECTS["stribeck_velocity"], EFFECTS["creep_time"]


ALL_ON_ARM = ALL | {"stribeck_velocity": 0.2, "friction_gradient": 1.0, "backlash": 1e-3} | {
    "sheath_compliance": 1e-4, "output_compliance": 1e-4, "tendon_mass": 0.02,
    "viscous_friction": 0.5, "creep_time": 0.02,
}  # fmt: skip


class Drives:
    """A bent sheath; a slide at each end winds tendon in, 1 m a metre, and stays where it is put.

    Args:
        timestep: [s].
        law: attributes of the sheath.
    """

    def __init__(self, timestep=1e-3, guides=GUIDES, bend=BEND, **law):
        spec = mujoco.MjSpec()
        spec.option.timestep = timestep
        spec.option.gravity = [0.0, 0.0, 0.0]
        for name in ("reel", "drum"):
            body = spec.worldbody.add_body(name=name)
            body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_SLIDE)
            body.add_geom(size=[0.01, 0, 0], mass=1e6, contype=0, conaffinity=0)
        add_tendon(spec, "tendon", add_sites(spec, "s", arc_points(LENGTH, bend, guides)))
        law = {"axial_stiffness": EA, "friction": 0.2, "pretension": PRETENSION} | law
        ends = {"reel_joint": "reel", "reel_radius": 1, "output_joint": "drum", "output_radius": 1}
        shown = ("tension", "friction_work", "reel_displacement", "unsolved")
        add_friction(spec, "tendon", name="sheath", sensors=shown, **ends, **law)
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        self.timestep = timestep

    def step(self, reel, drum=0.0):
        """One step with both drives at rest in a place; T_in and T_out [N]."""
        self.data.qpos[:], self.data.qvel[:] = (reel, drum), 0.0
        mujoco.mj_step(self.model, self.data)
        return self.ends

    def follow(self, reel, drum=0.0):
        """(steps, 2) T_in and T_out along two histories."""
        reel, drum = np.broadcast_arrays(reel, drum)
        return np.array([self.step(*at) for at in zip(reel, drum, strict=True)])

    def draw(self, speed, steps):
        """Draw the whole tendon through at a speed; T_in and T_out after that."""
        way = self.data.qpos[0] + speed * self.timestep * np.arange(1, steps + 1)
        return self.follow(way, -way)[-1]

    @property
    def tension(self):
        """Of every segment [N]."""
        return self.data.sensor("tension").data.copy()

    @property
    def ends(self):
        """T_in and T_out [N]."""
        return self.tension[[0, -1]]

    @property
    def loss(self):
        """ln T_in/T_out."""
        return float(np.log(self.ends[0] / self.ends[1]))

    @property
    def unsolved(self):
        """Steps that were not solved."""
        return self.data.sensor("unsolved").data[0]

    def tables(self):
        """Scalars, segments and guides of the sheath."""
        return unpacked(self.model, self.data)

    def forces(self):
        """(2,) force that each drive needs to hold its place [N]."""
        return -self.data.qfrc_passive.copy()


RADIUS, INERTIA, SPRING = 0.01, 0.02, 20e3
SERVO_PRETENSION = 20.0


def hand(
    friction=0.0,
    timestep=0.0005,
    integrator="Euler",
    radius=RADIUS,
    inertia=INERTIA,
    bend=2.0,
    guides=4,
    mass=0.05,
    **servo,
):
    """A motor with a spool pulls through a sheath on a slider that a spring holds."""
    spec = mujoco.MjSpec()
    spec.option.timestep = timestep
    spec.option.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator.upper()}")
    spec.option.gravity = [0.0, 0.0, 0.0]
    points = arc_points(0.4, bend, guides)
    sites = add_sites(spec, "guide", points[:-1])
    heading = (points[-1] - points[-2]) / np.linalg.norm(points[-1] - points[-2])
    load = spec.worldbody.add_body(name="load", pos=points[-1])
    slide = load.add_joint(name="load", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=-heading)
    slide.stiffness[0], slide.springref = SPRING, -SERVO_PRETENSION / SPRING
    slide.damping[0] = 2.0 * np.sqrt(SPRING * mass)
    load.add_geom(size=[0.01, 0.0, 0.0], mass=mass, contype=0, conaffinity=0)
    load.add_site(name="output")
    add_tendon(spec, "tendon", [*sites, "output"])
    motor = spec.worldbody.add_body(name="motor")
    joint = motor.add_joint(name="motor", type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0.0, 0.0, 1.0])
    joint.armature = inertia
    motor.add_geom(size=[0.01, 0.0, 0.0], mass=1e-6, contype=0, conaffinity=0)
    add_friction(
        spec,
        "tendon",
        name="sheath",
        friction=friction,
        axial_stiffness=10e3,
        pretension=SERVO_PRETENSION,
        reel_joint="motor",
        reel_radius=radius,
    )
    add_servo(spec, "tendon", **({"tension_gain": 7.0, "velocity_gain": 1.0} | servo))
    return spec


def servo_model(**values):
    return hand(**values).compile()


def servo_stiffness():
    """K_t of the servo's transmission without friction [N/m]."""
    return 1.0 / (1.0 / SPRING + 0.4 / 10e3)


def respond(model, reference, data=None):
    """Columns time, T_out, T_in, θ, θ̇, actuator force, a row a step."""
    data = mujoco.MjData(model) if data is None else data
    rows = []
    for value in reference:
        data.ctrl[0] = value
        mujoco.mj_step(model, data)
        rows.append(
            (
                data.time - model.opt.timestep,
                data.sensor("output_tension").data[0],
                data.sensor("input_tension").data[0],
                data.joint("motor").qpos[0],
                data.joint("motor").qvel[0],
                data.actuator_force[0],
            )
        )
    return np.array(rows)


DRIVEN = """
<mujoco>
  <option integrator="implicitfast"/>
  <worldbody>
    <site name="a" pos="-.1 0 .03"/><geom name="drum" type="cylinder" size=".02 .1" zaxis="0 1 0"/>
    <site name="side" pos="0 0 .05"/><site name="k" pos="-.02 0 .06"/>
    <body>
      <joint name="elbow" axis="0 1 0" range="-60 60" damping=".01" {joint}/>
      <geom type="capsule" size=".01" fromto="0 0 0 .2 0 0" contype="0" conaffinity="0"/>
      <site name="b" pos=".1 0 .02"/><site name="c" pos=".2 0 .03"/>
    </body>
  </worldbody>
  <tendon>
    <spatial name="wrapped"><site site="a"/><geom geom="drum" sidesite="side"/><site site="b"/>
      <site site="c"/></spatial>
    <spatial name="sprung" stiffness="50" springlength=".1 .2"><site site="a"/><site site="k"/>
      <site site="c"/></spatial>
    <spatial name="branched" stiffness="60"><site site="a"/><site site="b"/><pulley divisor="2"/>
      <site site="a"/><site site="b"/><site site="c"/></spatial>
    {tendons}
  </tendon>
  <actuator>{actuators}</actuator>
</mujoco>
"""


def driven_xml(
    tendons="", actuators='<motor name="pull" tendon="wrapped"/>', joint='armature=".01"'
):
    """A link with a tendon around a drum, one with a spring and one that branches."""
    return DRIVEN.format(tendons=tendons, actuators=actuators, joint=joint)


def driven():
    spec = mujoco.MjSpec.from_string(driven_xml())
    return add_friction(spec, "*", friction=0.2, arc_guides=2).compile()


def reeled():
    return fixed_sheaths([{"guides": 6, "bend": 2.0, "friction": 0.2, "pretension": 20.0}] * 2)


MODELS = {
    "wound": lambda: arm(spools=True),
    "reeled": reeled,
    "driven": driven,
    "servo": lambda: hand(period=0.002, delay=0.003).compile(),
}


def moved(model):
    data = mujoco.MjData(model)
    data.ctrl[:] = 1e-3
    mujoco.mj_step(model, data, 5)
    return data.plugin_state.copy()


FOLDER = Path(os.environ.get("TENDON_MJ_MODELS") or "/nowhere")
NAMES = ("arm26", "myoelbow", "aero_hand", "myohand")
MUJOCO = tuple(int(part) for part in mujoco.__version__.split(".")[:2])
TOO_NEW = {"aero_hand"} if MUJOCO < (3, 16) else set()
needs_aero_hand = pytest.mark.skipif(
    "aero_hand" in TOO_NEW, reason="MuJoCo before 3.16 cannot read aero_hand.xml"
)
hands_on_plugin_states = pytest.mark.skipif(
    MUJOCO < (3, 14), reason="`MjSpec.recompile` drops plugin states before MuJoCo 3.14"
)
wraps_half_turns = pytest.mark.skipif(
    MUJOCO < (3, 16),
    reason="where a tendon wraps by half a turn, its length is inexact or NaN before MuJoCo 3.16",
)
GIVEN = [
    pytest.param(
        name,
        marks=[
            pytest.mark.skipif(
                not (FOLDER / f"{name}.xml").is_file(),
                reason=f"TENDON_MJ_MODELS names no folder with {name}.xml",
            ),
            *([needs_aero_hand] if name == "aero_hand" else []),
        ],
    )
    for name in NAMES
]


def stock(name):
    """The model as it was published."""
    return mujoco.MjModel.from_xml_path(str(FOLDER / f"{name}.xml"))


def sheathed(name, **values):
    """The model with a sheath on each tendon that an actuator pulls on."""
    spec = mujoco.MjSpec.from_file(str(FOLDER / f"{name}.xml"))
    on_tendon = mujoco.mjtTrn.mjTRN_TENDON
    tendons = sorted({a.target for a in spec.actuators if a.trntype == on_tendon})
    return add_friction(spec, tendons, **values).compile()


def random_pose(model, rng):
    """A pose with each hinge and slide anywhere in its range, the others at `qpos0`."""
    qpos = model.qpos0.copy()
    hinge_or_slide = model.jnt_type >= mujoco.mjtJoint.mjJNT_SLIDE.value
    for j in np.flatnonzero(hinge_or_slide & model.jnt_limited.astype(bool)):
        qpos[model.jnt_qposadr[j]] = rng.uniform(*model.jnt_range[j])
    return qpos
