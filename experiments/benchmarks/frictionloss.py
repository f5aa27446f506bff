"""MuJoCo's own `frictionloss` in place of a sheath: its cost, and how far from the capstan law.

A motor pulls the bench's tendon with a slow T_in(t) between half and twice its mean. `frictionloss`
is one force, whatever the tension; here it is what the capstan law takes from the mean tension,
T_m (1 − e^{−λ}). MuJoCo solves it as a soft constraint, which creeps where it should hold; with the
stiffest settings it is that of a rigid contact, and what remains is the law's own error.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import mujoco
import numpy as np

from tendon_mj import theory
from tendon_mj.attach import add_friction, view_sheath
from tendon_mj.lab.step_cost import Quartiles, StepCost, mujoco_tendon_bench, run_along, step_times
from tendon_mj.models import Bench
from tendon_mj.typing import FloatArray

STIFF_SOLREF_STEPS = 2.0  # time constant in steps: the shortest that MuJoCo takes
STIFF_SOLIMP = (0.99, 0.999, 0.001, 0.5, 2.0)
_SPAN = 2.0  # largest tension over the mean, and the mean over the least
_STEPS = 4000


@dataclass(frozen=True)
class Deviation:
    """Deviation of T_out from the capstan law, T_out/T_out(capstan) − 1.

    Attributes:
        largest, rms: over the whole motion [-].
        at_most, at_least: at the largest and at the least input tension [-].
    """

    largest: float
    rms: float
    at_most: float
    at_least: float

    def result(self) -> dict[str, float]:
        """Plain numbers for `result.json`."""
        return {
            "max_relative_error": self.largest,
            "rms_relative_error": self.rms,
            "relative_error_at_twice_the_mean": self.at_most,
            "relative_error_at_half_the_mean": self.at_least,
        }


@dataclass(frozen=True)
class Frictionloss:
    """`frictionloss` beside the sheath, on the bench pulled by a motor.

    Attributes:
        force: of `frictionloss` [N].
        cost, sheath_cost: of a step, over the bench without friction.
        error: of a constraint as stiff as MuJoCo takes, against the capstan law.
        default_error: of one with MuJoCo's default settings.
        sheath_error: of the sheath.
    """

    force: float
    cost: StepCost
    sheath_cost: StepCost
    error: Deviation
    default_error: Deviation
    sheath_error: Deviation

    @property
    def over_sheath(self) -> Quartiles:
        """Cost of a step with `frictionloss` over one with the sheath, of each round [-]."""
        return Quartiles.of(self.cost.steps / self.sheath_cost.steps)

    def result(self) -> dict[str, object]:
        """Plain numbers for `result.json`."""
        return {
            "force_N": self.force,
            "step_cost": self.cost.result(),
            "step_cost_over_sheath": self.over_sheath.result(),
            "output_tension": self.error.result(),
            "output_tension_default_solver_settings": self.default_error.result(),
            "sheath": {
                "step_cost": self.sheath_cost.result(),
                "output_tension": self.sheath_error.result(),
            },
        }


def motor_bench(
    bench: Bench, *, frictionloss: float = 0.0, stiff: bool = False, friction: float | None = None
) -> mujoco.MjSpec:
    """The bench pulled by a motor, control T_in [N], without friction unless it is given.

    Args:
        bench: its parameters.
        frictionloss: MuJoCo's, of the tendon [N].
        stiff: whether its constraint is as stiff as MuJoCo takes.
        friction: μ of a sheath; default: none.
    """
    spec = mujoco_tendon_bench(bench)
    tendon = spec.tendon("tendon")
    tendon.stiffness[0] = 0.0
    tendon.frictionloss = frictionloss
    if stiff:
        tendon.solref_friction = [STIFF_SOLREF_STEPS * bench.timestep, 1.0]
        tendon.solimp_friction = STIFF_SOLIMP
    motor = spec.add_actuator(name="motor", trntype=mujoco.mjtTrn.mjTRN_TENDON, target="tendon")
    motor.set_to_motor()
    motor.gear[0] = -1.0  # a positive control pulls
    if friction is not None:
        add_friction(spec, "tendon", friction=friction, sensors=())
    return spec


def slow_tension(bench: Bench, steps: int) -> FloatArray:
    """(steps,) T_in, one cycle from T_0 between half and twice as much [N]."""
    return bench.pretension * _SPAN ** np.sin(np.linspace(0.0, 2.0 * np.pi, steps))


def output_tension(spec: mujoco.MjSpec, pulled: FloatArray) -> FloatArray:
    """(steps,) T_out that a motor's T_in leaves behind `frictionloss` or a sheath [N]."""
    model = spec.compile()
    data = mujoco.MjData(model)
    view = view_sheath(model, data, "tendon") if model.nplugin else None
    result = np.empty(len(pulled))
    for k, tension in enumerate(pulled):
        data.ctrl[0] = tension
        mujoco.mj_step(model, data)
        result[k] = view.output_tension if view else tension - data.efc_force[0]
    return result


def deviation(pulled: FloatArray, output: FloatArray, bench: Bench) -> Deviation:
    """Deviation of a T_out from the capstan law for the history of T_in.

    Args:
        pulled: (steps,) T_in [N].
        output: (steps,) T_out [N].
        bench: its λ, and T_0 as the tension before.
    """
    off = output / theory.output_tension(pulled, bench.exponent, bench.pretension) - 1.0
    return Deviation(
        largest=float(np.abs(off).max()),
        rms=float(np.sqrt(np.mean(off**2))),
        at_most=float(off[pulled.argmax()]),
        at_least=float(off[pulled.argmin()]),
    )


def compare_frictionloss(bench: Bench, *, rounds: int = 7) -> Frictionloss:
    """Cost and error of `frictionloss`, and of a sheath in its place.

    Args:
        bench: its parameters; λ and the mean tension T_0 give the force.
        rounds: in each of which the bench without friction and both others run.
    """
    force = bench.pretension * -math.expm1(-bench.exponent)
    pulled = slow_tension(bench, _STEPS)
    specs = (
        motor_bench(bench),
        motor_bench(bench, frictionloss=force),
        motor_bench(bench, friction=bench.friction),
    )
    free, lossy, sheathed = step_times([run_along(spec, pulled) for spec in specs], rounds).T

    def error(spec: mujoco.MjSpec) -> Deviation:
        return deviation(pulled, output_tension(spec, pulled), bench)

    return Frictionloss(
        force=force,
        cost=StepCost(lossy, free),
        sheath_cost=StepCost(sheathed, free),
        error=error(motor_bench(bench, frictionloss=force, stiff=True)),
        default_error=error(motor_bench(bench, frictionloss=force)),
        sheath_error=error(motor_bench(bench, friction=bench.friction)),
    )
