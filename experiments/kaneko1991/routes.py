"""Four routes to the tensions without MuJoCo; each takes the tendon and a history of the input.

Closed form, continuum and the sheath alone know neither time nor mass. The elements carry masses,
chosen so that they move quasi-statically. `mujoco_routes` has the two routes in MuJoCo.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from experiments import references
from experiments.kaneko1991.paper_tendon import PaperTendon
from experiments.sheath_bench import drive_sheath
from tendon_mj import theory
from tendon_mj.errors import TendonError
from tendon_mj.typing import FloatArray

Drive = Literal["tension", "displacement"]  # the input that is prescribed: T_in or ξ_in


@dataclass(frozen=True, eq=False)
class Trace:
    """Tensions and displacement that a route gives at the samples of a history, each (samples,).

    Args:
        input_tension, output_tension: T_in, T_out [N].
        input_displacement: ξ_in [m].
    """

    input_tension: FloatArray
    output_tension: FloatArray
    input_displacement: FloatArray


def closed_form(tendon: PaperTendon, history: FloatArray, drive: Drive) -> Trace:
    """Exact play operator of `tendon_mj.theory`; F_c is ``tension_offset``."""
    offset = tendon.tension_offset
    sheath = (tendon.exponent, tendon.pretension + offset, tendon.axial_stiffness, tendon.length)
    if drive == "displacement":
        near, far = theory.driven_tensions(history, *sheath, tendon.output_stiffness)
        return Trace(near - offset, far - offset, history)
    far = theory.output_tension(history + offset, *sheath[:2])
    travel = theory.displacement(history + offset, *sheath, tendon.output_stiffness)
    return Trace(history, far - offset, travel)


def continuum(
    tendon: PaperTendon, history: FloatArray, drive: Drive, intervals: int = 256
) -> Trace:
    """Play operators on a grid (`experiments.references`); F_c is ``tension_offset``."""
    offset = tendon.tension_offset
    model = references.continuum(
        tendon.bend,
        length=tendon.length,
        axial_stiffness=tendon.axial_stiffness,
        friction=tendon.friction,
        pretension=tendon.pretension + offset,
        environment_stiffness=tendon.output_stiffness,
        intervals=intervals,
    )
    if drive == "tension":
        run = references.simulate_continuum(model, input_tension=history + offset)
    else:
        run = references.simulate_continuum(model, input_displacement=history)
    return Trace(run.input_tension - offset, run.output_tension - offset, run.input_displacement)


def element_chain(
    tendon: PaperTendon, n: int, mass: float = 1.0, damping: float = 0.0
) -> references.ElementChain:
    """Lumped elements of the paper's Fig. 3; mass [kg] and damping [N s/m] of the whole tendon."""
    return references.uniform_chain(
        n,
        length=tendon.length,
        bend_angle=tendon.bend,
        axial_stiffness=tendon.axial_stiffness,
        pretension=tendon.pretension,
        static_friction=(
            tendon.friction if tendon.static_friction is None else tendon.static_friction
        ),
        dynamic_friction=tendon.friction,
        friction_force=tendon.constant_friction,
        mass=mass,
        damping=damping,
        environment_stiffness=tendon.output_stiffness,
    )


def elements(
    chain: references.ElementChain,
    time: FloatArray,
    history: FloatArray,
    drive: Drive,
    time_step: float,
) -> Trace:
    """Eq. (25) integrated by `experiments.references` with steps of at most ``time_step`` [s].

    Raises:
        TendonError: a step was not solved.
    """
    if drive == "tension":
        run = references.simulate_chain(chain, time, input_tension=history, time_step=time_step)
    else:
        run = references.simulate_chain(
            chain, time, input_displacement=history, time_step=time_step
        )
    if run.unsolved_steps:
        raise TendonError(f"{run.unsolved_steps} of {run.steps} steps of the elements not solved")
    return Trace(run.input_tension, run.output_tension, run.input_displacement)


def quasi_static_elements(
    tendon: PaperTendon,
    time: FloatArray,
    history: FloatArray,
    drive: Drive,
    n: int,
    duration: float,
    slowness: float,
) -> Trace:
    """Elements with μ_s = μ_d, so light that the lowest mode is fast against ``duration`` [s]."""
    chain = references.quasi_static(element_chain(tendon, n), duration, slowness=slowness)
    return elements(chain, time, history, drive, 4.0 * chain.time_step)


def sheath_alone(tendon: PaperTendon, history: FloatArray, drive: Drive, guides: int) -> Trace:
    """Flow solver of `tendon_mj.sheath` without MuJoCo.

    Raises:
        TendonError: a flow was not solved.
    """
    run = drive_sheath(
        history,
        tendon.law,
        length=tendon.length,
        bend=tendon.bend,
        guides=guides,
        output_stiffness=tendon.output_stiffness,
        by_tension=drive == "tension",
    )
    if run.unsolved:
        raise TendonError(f"{run.unsolved} of {len(history)} flows of the sheath not solved")
    return Trace(run.input_tension, run.output_tension, run.input_displacement)
