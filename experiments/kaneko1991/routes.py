"""Four routes to the tensions without MuJoCo: each takes the rig and a history of the input.

Closed form, continuum and the sheath alone know neither time nor mass. The elements carry masses,
chosen for them to be slow. `paper_mujoco` has the two routes in MuJoCo.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from experiments.kaneko1991.rig import Rig
from tendon_mj import reference, theory
from tendon_mj.errors import TendonError
from tendon_mj.sheath.bench import drive_displacement, drive_tension

Array = NDArray[np.float64]
Drive = Literal["tension", "displacement"]


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


def elements_chain(
    rig: Rig, n: int, mass: float = 1.0, damping: float = 0.0
) -> reference.ElementChain:
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
