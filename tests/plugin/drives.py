"""A sheath between two drives whose positions the tests prescribe."""

import mujoco
import numpy as np

from tendon_mj.attach import add_friction, add_sites, add_tendon, arc_points
from tests.plugin.models import unpacked

LENGTH, BEND, GUIDES, EA, PRETENSION = 0.5, 2.0, 8, 20e3, 30.0
# every effect at once, each to a degree that shows
ALL = {
    "static_friction": 0.25,
    "constant_friction": 0.2,
    "stribeck_friction": 0.05,
    "stribeck_velocity": 0.02,
    "viscous_friction": 2.0,
    "direction_asymmetry": 0.2,
    "friction_gradient": 3.0,
    "friction_drift": 0.4,
    "backlash": 2e-4,
    "stiffening": 2.0,
    "creep": 0.3,
    "creep_time": 0.05,
    "sheath_compliance": 1e-6,
    "tendon_mass": 2e-3,
    "extra_bend": 0.3,
    "axial_damping": 1.0,
}
EFFECTS = {name: {name: value} for name, value in ALL.items()} | {
    "stribeck_friction": {"stribeck_friction": 0.05, "stribeck_velocity": 0.02},
    "creep": {"creep": 0.3, "creep_time": 0.05},
}
del EFFECTS["stribeck_velocity"], EFFECTS["creep_time"]


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
        add_friction(spec, "tendon", sensors=shown, **ends, **law)
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
