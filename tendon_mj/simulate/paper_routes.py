"""One tendon, six routes to its tensions: each takes the rig and a history of the input.

Closed form and continuum know neither time nor mass; so does the sheath alone. The plugin in MuJoCo
is driven by ξ_in. The elements, ours and in MuJoCo, carry masses chosen for them to be slow.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import mujoco
import numpy as np
from mujoco import rollout
from numpy.typing import NDArray

from tendon_mj import reference, theory
from tendon_mj.attach import add_friction, add_sites, add_tendon, arc_points
from tendon_mj.errors import InvalidValueError, TendonError
from tendon_mj.sheath.bench import drive_displacement, drive_tension
from tendon_mj.simulate.chain import Chain, build_chain
from tendon_mj.simulate.paper_rig import Rig

Array = NDArray[np.float64]
Drive = Literal["tension", "displacement"]
CARRIAGE = 0.1  # mass behind the output spring in MuJoCo [kg]
CARRIAGE_DAMPING_RATIO = 0.1  # its drag and its ringing both count as errors of the tendon


@dataclass(frozen=True, eq=False)
class Trace:
    """What a route gave at the instants asked for, each (samples,).

    Args:
        input_tension, output_tension: T_in, T_out [N].
        input_displacement: ξ_in [m].
    """

    input_tension: Array
    output_tension: Array
    input_displacement: Array


def closed_form(rig: Rig, history: Array, drive: Drive) -> Trace:
    """Exact play operator of `tendon_mj.theory`; F_c by the shift of ``Rig.tension_offset``."""
    shift = rig.tension_offset
    sheath = (rig.exponent, rig.pretension + shift, rig.axial_stiffness, rig.length)
    if drive == "displacement":
        near, far = theory.driven_tensions(history, *sheath, rig.output_stiffness)
        return Trace(near - shift, far - shift, history)
    far = theory.output_tension(history + shift, *sheath[:2])
    travel = theory.displacement(history + shift, *sheath, rig.output_stiffness)
    return Trace(history, far - shift, travel)


def continuum(rig: Rig, history: Array, drive: Drive, intervals: int = 256) -> Trace:
    """Play on a grid of `tendon_mj.reference`; F_c by the same shift."""
    shift = rig.tension_offset
    model = reference.continuum(
        rig.bend,
        length=rig.length,
        axial_stiffness=rig.axial_stiffness,
        friction=rig.friction,
        pretension=rig.pretension + shift,
        environment_stiffness=rig.output_stiffness,
        intervals=intervals,
    )
    if drive == "tension":
        run = reference.simulate_continuum(model, input_tension=history + shift)
    else:
        run = reference.simulate_continuum(model, input_displacement=history)
    return Trace(run.input_tension - shift, run.output_tension - shift, run.input_displacement)


def elements_chain(rig: Rig, n: int, mass: float = 1.0, damping: float = 0.0) -> (
    reference.ElementChain
):
    """The rig as the paper's Fig. 3, mass [kg] and damping [N s/m] of the whole tendon."""
    return reference.uniform_chain(
        n,
        length=rig.length,
        bend_angle=rig.bend,
        axial_stiffness=rig.axial_stiffness,
        pretension=rig.pretension,
        static_friction=rig.friction if rig.static_friction is None else rig.static_friction,
        dynamic_friction=rig.friction,
        friction_force=rig.constant_friction,
        mass=mass,
        damping=damping,
        environment_stiffness=rig.output_stiffness,
    )


def elements(
    chain: reference.ElementChain, time: Array, history: Array, drive: Drive, time_step: float
) -> Trace:
    """Eq. (25) integrated by `tendon_mj.reference`; ``time_step`` is the longest [s]."""
    if drive == "tension":
        run = reference.simulate_chain(chain, time, input_tension=history, time_step=time_step)
    else:
        run = reference.simulate_chain(chain, time, input_displacement=history, time_step=time_step)
    if run.unsolved_steps:
        raise TendonError(f"{run.unsolved_steps} of {run.steps} steps of the elements not solved")
    return Trace(run.input_tension, run.output_tension, run.input_displacement)


def slow_elements(
    rig: Rig, time: Array, history: Array, drive: Drive, n: int, scale: float, slowness: float
) -> Trace:
    """Elements so light that inertia is small at the time scale ``scale`` [s], μ_s = μ_d."""
    chain = reference.quasi_static(elements_chain(rig, n), scale, slowness=slowness)
    return elements(chain, time, history, drive, 4.0 * chain.time_step)


def sheath_alone(rig: Rig, history: Array, drive: Drive, guides: int) -> Trace:
    """The flow solver of `tendon_mj.sheath` without MuJoCo."""
    follow = drive_tension if drive == "tension" else drive_displacement
    run = follow(
        history,
        rig.law,
        length=rig.length,
        bend=rig.bend,
        guides=guides,
        output_stiffness=rig.output_stiffness,
    )
    if run.unsolved:
        raise TendonError(f"{run.unsolved} of {len(history)} flows of the sheath not solved")
    return Trace(run.input_tension, run.output_tension, run.input_displacement)


def plugin_model(rig: Rig, guides: int, timestep: float) -> mujoco.MjModel:
    """The rig in MuJoCo: a reel, the sheath, and at the output nothing or a sprung carriage."""
    spec = mujoco.MjSpec()
    spec.option.timestep = timestep
    spec.option.gravity = [0.0, 0.0, 0.0]
    points = arc_points(rig.length, rig.bend, guides)
    sites = add_sites(spec, "guide", points[:-1])
    body = spec.worldbody
    if math.isfinite(rig.output_stiffness):
        body = spec.worldbody.add_body(name="output", pos=points[-1])
        axis = points[-2] - points[-1]
        joint = body.add_joint(name="output", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis)
        total = rig.output_stiffness + rig.axial_stiffness / rig.length
        joint.stiffness[0] = rig.output_stiffness
        joint.springref = -rig.pretension / rig.output_stiffness
        joint.damping[0] = 2.0 * CARRIAGE_DAMPING_RATIO * math.sqrt(total * CARRIAGE)
        body.add_geom(size=[0.01, 0.0, 0.0], mass=CARRIAGE, contype=0, conaffinity=0)
        body.add_site(name="output")
    else:
        body.add_site(name="output", pos=points[-1])
    add_tendon(spec, "tendon", [*sites, "output"])
    add_friction(
        spec,
        "tendon",
        friction=rig.friction,
        static_friction=rig.static_friction,
        constant_friction=rig.constant_friction,
        axial_stiffness=rig.axial_stiffness,
        pretension=rig.pretension,
        reel="reel",
        sensors=("input_tension", "output_tension", "unsolved"),
    )
    return spec.compile()


def roll(model: mujoco.MjModel, control: Array, threads: int = 1) -> dict[str, Array]:
    """Let the one actuator follow ``control``, (steps,) or (runs, steps); sensors by name.

    Unlike a plain `mujoco.rollout` it keeps no states: a sheath of 64 guides has thousands.

    Raises:
        TendonError: a simulation became unstable or left a flow unsolved.
    """
    commands = np.ascontiguousarray(np.atleast_2d(control))
    runs, steps = commands.shape
    data = [mujoco.MjData(model) for _ in range(threads)]
    whole = mujoco.mjtState.mjSTATE_FULLPHYSICS
    start = np.empty((runs, mujoco.mj_stateSize(model, whole)))
    for row in start:
        mujoco.mj_getState(model, data[0], row, whole)
    shown = np.empty((runs, steps, model.nsensordata))
    with rollout.Rollout(nthread=threads if threads > 1 else 0) as runner:
        runner.rollout(
            [model] * runs,
            data,
            start,
            commands[:, :, None],
            skip_checks=True,
            nstep=steps,
            sensordata=shown,
        )
    if not np.isfinite(shown).all() or any(d.warning.number.any() for d in data):
        raise TendonError(f"a simulation at a step of {model.opt.timestep:g} s became unstable")
    shown = shown.reshape(*control.shape, model.nsensordata)
    names = [model.sensor(k).name for k in range(model.nsensor)]
    found = {name: shown[..., int(model.sensor(name).adr[0])] for name in names}
    if "unsolved" in found and found["unsolved"].max() > 0.0:
        raise TendonError(f"{found['unsolved'].max():g} flows of the plugin were not solved")
    return found


def plugin(
    rig: Rig,
    time: Array,
    displacement: Array,
    guides: int,
    timestep: float | None = None,
    threads: int = 1,
) -> Trace:
    """The engine plugin in MuJoCo, its reel following ξ_in [m], (samples,) or (runs, samples).

    Args:
        time: even [s]; a held output has no dynamics and is stepped from sample to sample.
        timestep: where the output is sprung [s]; ξ_in is linear between samples.
        threads: that share the runs.
    """
    gap = float(time[1] - time[0])
    stride = 1 if timestep is None else max(1, round(gap / timestep))
    fine = time[0] + gap / stride * np.arange((len(time) - 1) * stride + 1)
    reel = np.apply_along_axis(lambda row: np.interp(fine, time, row), -1, displacement)
    found = roll(plugin_model(rig, guides, gap / stride), reel, threads)
    near, far = (found[f"{end}_tension"][..., ::stride] for end in ("input", "output"))
    return Trace(near, far, displacement)


def mujoco_elements(
    rig: Rig, time: Array, history: Array, drive: Drive, n: int, mass: float, damping: float
) -> Trace:
    """Fig. 3 in MuJoCo (`tendon_mj.simulate.chain`) at its own step."""
    if drive == "tension" and history[0] != rig.pretension:
        raise InvalidValueError(f"history[0] = {history[0]:g} [N] must be T_0 to start from rest")
    chain = Chain(
        elements=n,
        friction=rig.friction,
        static_friction=rig.static_friction,
        constant_friction=rig.constant_friction,
        length=rig.length,
        bend=rig.bend,
        axial_stiffness=rig.axial_stiffness,
        pretension=rig.pretension,
        mass=mass,
        damping=damping,
        output_stiffness=rig.output_stiffness,
    )
    model = build_chain(chain, drive).compile()
    fine = np.arange(time[0], time[-1] + chain.step, chain.step)
    found = roll(model, np.interp(fine, time, history))
    names = ("input_tension", "output_tension", "input_displacement")
    return Trace(*(np.interp(time, fine, found[name]) for name in names))
