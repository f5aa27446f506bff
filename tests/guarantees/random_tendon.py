"""Any tendon on any chain of links, with any drive and any law: what the promises are tried on."""

import os
import re
from dataclasses import dataclass

import mujoco
import numpy as np
from hypothesis import HealthCheck, settings
from hypothesis import strategies as some

from tendon_mj import Spool, add_friction

# examples of each law: some as a part of the suite, and more where they are asked for
EXAMPLES = int(os.environ.get("TENDON_MJ_EXAMPLES", "40"))
thorough = settings(
    max_examples=EXAMPLES, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large]
)

WOUND = ("reel", "reel_joint", "spool")  # drives that wind in a tendon of given length
DRIVEN = ("motor", "motor and spring", "position", "velocity", "muscle")
# which a driven tendon does not take
WINDING = ("viscous_friction", "backlash", "tendon_mass", "sheath_compliance", "output_compliance")
SCALES = {"stribeck_friction": ("stribeck_velocity", 0.02), "creep": ("creep_time", 0.01)}
TIMESTEPS = (1e-4, 5e-4, 1e-3, 2e-3, 5e-3)
INTEGRATORS = ("Euler", "implicit", "implicitfast", "RK4")
_ACTUATORS = {
    "motor": '<motor tendon="t" gear="1.5" ctrlrange="-30 5"/>',
    "position": '<position tendon="t" kp="300" dampratio="1" ctrlrange="0.05 0.6"/>',
    "velocity": '<velocity tendon="t" kv="20" ctrlrange="-1 1"/>',
    "muscle": '<muscle tendon="t" force="60" lengthrange="0.1 0.8" ctrlrange="0 1"/>',
    "motor and spring": '<motor tendon="t" ctrlrange="-10 2"/>',
    "reel": '<motor joint="j0" ctrlrange="-1 1"/>',
    "reel_joint": '<motor joint="winch" ctrlrange="-3 3"/>',
    "spool": '<motor tendon="t" ctrlrange="-40 0"/>',
}
DIVERGED = ("mjWARN_BADQPOS", "mjWARN_BADQVEL", "mjWARN_BADQACC")


@dataclass(frozen=True)
class Case:
    """A model without friction, and what is to become of it.

    Attributes:
        xml: the model; its tendon is ``t``.
        drive: what moves the tendon, of WOUND or DRIVEN.
        arguments: of `add_friction`.
        seed: of the controls and of where the joints are set anew.
    """

    xml: str
    drive: str
    arguments: dict
    seed: int

    def model(self, **more):
        """The model with friction."""
        spec = mujoco.MjSpec.from_string(self.xml)
        add_friction(spec, "t", **self.arguments | more)
        return spec.compile()


@some.composite
def cases(draw, drives=WOUND + DRIVEN, laws=None):
    """A case of one of the drives; ``laws`` draws what is given to `add_friction`."""
    drive = draw(some.sampled_from(drives))
    seed = draw(some.integers(0, 2**32 - 1))
    rng = np.random.default_rng(seed)
    links = draw(some.integers(1, 3))
    pulleys = drive in DRIVEN and draw(some.booleans())
    path, bodies = _chain(draw, rng, links)
    if pulleys:
        path += f'<pulley divisor="{draw(some.sampled_from([1, 2, 3.5]))}"/>'
        path += _branch(draw, path)
    winch = ""
    if drive == "reel_joint":
        winch = '<body pos="0 .4 0"><joint name="winch" axis="0 1 0" damping=".05"'
        winch += ' armature="2e-3"/><geom size=".02" mass=".1"/></body>'
    spring = (
        'stiffness="80" springlength="0.1" damping="0.3"' if drive == "motor and spring" else ""
    )
    xml = f"""<mujoco><option timestep="{draw(some.sampled_from(TIMESTEPS))}"
        integrator="{draw(some.sampled_from(INTEGRATORS))}"/>
      <default><geom contype="0" conaffinity="0"/></default>
      <worldbody><site name="origin" pos="-.15 0 .06"/><site name="fixed" pos="-.05 .01 .05"/>
        <site name="branch" pos="-.05 .08 .05"/>{bodies}{winch}</worldbody>
      <tendon><spatial name="t" {spring}>{path}</spatial></tendon>
      <actuator>{_ACTUATORS[drive]}</actuator></mujoco>"""
    arguments = draw(laws(drive) if laws else _laws(drive))
    if drive in WOUND:
        # what the step carries, which `largest_stiffness` says for a model at hand
        arguments.setdefault("axial_stiffness", draw(some.sampled_from([200.0, 2e3])))
        arguments.setdefault("pretension", draw(some.sampled_from([0.0, 1.0, 15.0])))
    if drive == "reel":
        arguments["reel"] = "reel"
    if drive == "reel_joint":
        arguments |= {"reel_joint": "winch", "reel_radius": 0.02}
    if drive == "spool":
        arguments["spool"] = Spool(radius=0.01, damping=1e-3)
    return Case(xml, drive, arguments, seed)


def _chain(draw, rng, links):
    """Path of a tendon over a chain of links, and its bodies."""
    path, bodies, ends = '<site site="origin"/><site site="fixed"/>', "", ""
    for k in range(links):
        axis = " ".join(map(str, np.round(rng.normal((0.0, 2.0, 0.0)), 3)))
        bodies += f"""<body pos="{0 if k == 0 else 0.12} 0 0">
          <joint name="j{k}" axis="{axis}" damping=".05" stiffness="1" armature="1e-3"/>
          <geom type="capsule" fromto="0 0 0 .12 0 0" size=".01" mass=".1"/>"""
        over = draw(some.sampled_from(["sites", "sites", "cylinder", "sphere"]))
        if over != "sites":
            size = ".015 .05" if over == "cylinder" else ".015"
            bodies += f'<geom name="g{k}" type="{over}" size="{size}" euler="90 0 0" mass=".01"/>'
            beside = draw(some.booleans())
            bodies += f'<site name="b{k}" pos="0 0 .03"/>' if beside else ""
            path += f'<geom geom="g{k}"' + (f' sidesite="b{k}"/>' if beside else "/>")
        for i in range(draw(some.integers(1, 2))):
            where = [0.03 + 0.07 * i, rng.uniform(-0.02, 0.02), rng.uniform(0.025, 0.05)]
            bodies += f'<site name="s{k}{i}" pos="{" ".join(map(str, np.round(where, 4)))}"/>'
            path += f'<site site="s{k}{i}"/>'
        ends += "</body>"
    return path, bodies + ends


def _branch(draw, path):
    """A branch that ends at the first link; it may begin where the one before ended."""
    start = draw(some.sampled_from(["branch", re.findall(r'site="(\w+)"', path)[-1]]))
    middle = '<site site="fixed"/>' if start != "fixed" else ""
    return f'<site site="{start}"/>{middle}<site site="s00"/>'


@some.composite
def _laws(draw, drive):
    law = {"friction": draw(some.sampled_from([0.0, 0.05, 0.15, 0.4, 1.0]))}
    if draw(some.booleans()):
        law["static_friction"] = law["friction"] * draw(some.sampled_from([1.0, 1.3, 2.0]))
    for name, values in {
        "constant_friction": [0.2, 2.0],
        "axial_damping": [1.0],
        "stiffening": [5.0],
        "direction_asymmetry": [-0.5, 0.3],
        "viscous_friction": [1.0, 10.0],
        "friction_gradient": [-2.0, 2.0],
        "load_gradient": [-0.02, 0.02],
        "friction_drift": [0.5],
        "backlash": [1e-3],
        "tendon_mass": [0.02],
        "sheath_compliance": [1e-6, 1e-4],
        "output_compliance": [1e-6, 1e-4],
        "stribeck_friction": [0.2],
        "creep": [0.3],
        "extra_bend": [-0.3, 1.0],
    }.items():
        if (drive in WOUND or name not in WINDING) and draw(some.integers(0, 3)) == 0:
            law[name] = draw(some.sampled_from(values))
            law |= [SCALES[name]] if name in SCALES else []
    return law


def control_range(model):
    """Lowest and highest control of each actuator; a reel's [m] has no limits of its own."""
    low, high = model.actuator_ctrlrange.T
    limited = model.actuator_ctrllimited.astype(bool)
    return np.where(limited, low, -0.01), np.where(limited, high, 0.01)


def moved(case, model, steps):
    """Data after each of some steps under random controls, the joints set anew now and then."""
    rng = np.random.default_rng(case.seed)
    data = mujoco.MjData(model)
    low, high = control_range(model)
    for step in range(steps):
        if step % 8 == 0:
            target = low + (high - low) * rng.random(model.nu)
        if step % 31 == 30:
            data.qpos[:] += rng.normal(scale=0.2, size=model.nq)
            data.qvel[:] = rng.normal(scale=1.0, size=model.nv)
        data.ctrl[:] += 0.3 * (target - data.ctrl)
        mujoco.mj_step(model, data)
        yield data


def diverged(data):
    """Whether MuJoCo has found the simulation unstable, and reset it."""
    return any(data.warning[getattr(mujoco.mjtWarning, name)].number for name in DIVERGED)
