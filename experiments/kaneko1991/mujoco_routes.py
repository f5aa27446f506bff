"""Two routes to the tensions in MuJoCo: the engine plugin, and the chain of elements."""

from __future__ import annotations

import math

import mujoco
import numpy as np

from experiments.kaneko1991.chain import Chain, build_chain
from experiments.kaneko1991.paper_tendon import PaperTendon
from experiments.kaneko1991.routes import Drive, Trace
from tendon_mj import add_friction, add_sites, add_tendon, arc_points
from tendon_mj.lab.replay import rollout_named_sensors
from tendon_mj.typing import FloatArray

CARRIAGE = 0.1  # mass on the output spring [kg]
CARRIAGE_DAMPING_RATIO = 0.1  # its drag and its ringing both count as errors of the tendon


def plugin_model(
    tendon: PaperTendon, guides: int, timestep: float, carriage: float = CARRIAGE
) -> mujoco.MjModel:
    """Model of the tendon in its sheath: a reel, and at the output a fixed end or a carriage.

    While the guides hold, the carriage hangs on the last half segment alone: unless the step is
    below about √(m L/(2 n EA)) [s] it rings there, and the guides turn the ringing into drift.
    """
    spec = mujoco.MjSpec()
    spec.option.timestep = timestep
    spec.option.gravity = [0.0, 0.0, 0.0]
    points = arc_points(tendon.length, tendon.bend, guides)
    sites = add_sites(spec, "guide", points[:-1])
    body = spec.worldbody
    if math.isfinite(tendon.output_stiffness):
        body = spec.worldbody.add_body(name="output", pos=points[-1])
        axis = points[-2] - points[-1]
        joint = body.add_joint(name="output", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis)
        total = tendon.output_stiffness + tendon.axial_stiffness / tendon.length
        joint.stiffness[0] = tendon.output_stiffness
        joint.springref = -tendon.pretension / tendon.output_stiffness
        joint.damping[0] = 2.0 * CARRIAGE_DAMPING_RATIO * math.sqrt(total * carriage)
        body.add_geom(size=[0.01, 0.0, 0.0], mass=carriage, contype=0, conaffinity=0)
        body.add_site(name="output")
    else:
        body.add_site(name="output", pos=points[-1])
    add_tendon(spec, "tendon", [*sites, "output"])
    add_friction(
        spec,
        "tendon",
        friction=tendon.friction,
        static_friction=tendon.static_friction,
        constant_friction=tendon.constant_friction,
        axial_stiffness=tendon.axial_stiffness,
        pretension=tendon.pretension,
        reel="reel",
        sensors=("input_tension", "output_tension", "unsolved"),
    )
    return spec.compile()


def plugin(
    tendon: PaperTendon,
    time: FloatArray,
    displacement: FloatArray,
    guides: int,
    timestep: float | None = None,
    threads: int = 1,
    carriage: float = CARRIAGE,
) -> Trace:
    """Run the engine plugin, its reel following ξ_in [m], (samples,) or (runs, samples).

    Args:
        tendon: parameters.
        time: evenly spaced [s].
        displacement: ξ_in, linear between samples [m].
        guides: n.
        timestep: where the output is a spring [s]; None steps from sample to sample, which suits a
            fixed output, since that has no dynamics.
        threads: that share the runs.
        carriage: mass on the output spring [kg].
    """
    gap = float(time[1] - time[0])
    stride = 1 if timestep is None else max(1, round(gap / timestep))
    fine = time[0] + gap / stride * np.arange((len(time) - 1) * stride + 1)
    reel = np.apply_along_axis(lambda row: np.interp(fine, time, row), -1, displacement)
    result = rollout_named_sensors(
        plugin_model(tendon, guides, gap / stride, carriage), reel, threads
    )
    near, far = (result[f"{end}_tension"][..., ::stride] for end in ("input", "output"))
    return Trace(near, far, displacement)


def mujoco_elements(
    tendon: PaperTendon,
    time: FloatArray,
    history: FloatArray,
    drive: Drive,
    n: int,
    mass: float,
    damping: float,
) -> Trace:
    """Run the elements of Fig. 3 in MuJoCo at their own step; a history of T_in starts at T_0."""
    chain = Chain(
        elements=n,
        friction=tendon.friction,
        static_friction=tendon.static_friction,
        constant_friction=tendon.constant_friction,
        length=tendon.length,
        bend=tendon.bend,
        axial_stiffness=tendon.axial_stiffness,
        pretension=tendon.pretension,
        mass=mass,
        damping=damping,
        output_stiffness=tendon.output_stiffness,
    )
    model = build_chain(chain, drive).compile()
    fine = np.arange(time[0], time[-1] + chain.step, chain.step)
    result = rollout_named_sensors(model, np.interp(fine, time, history))
    names = ("input_tension", "output_tension", "input_displacement")
    return Trace(*(np.interp(time, fine, result[name]) for name in names))
