"""Lumped elements of the paper's Fig. 3 as a MuJoCo model, for tendons whose inertia matters.

The tendon is a row of beads on slide joints, with mass and damping, midway between the guides of
the sheath. Between two beads it is a spring, a spatial tendon of its own, that bends over a guide:

    m_i ξ̈_i + c_i ξ̇_i = T_i⁻ − T_i⁺,    T_high = T_low e^{μφ/n} + F_c/n at every guide in between

`tendon_mj.sheath` solves each guide implicitly, so friction is proportional to tension within the
step and a guide that holds, holds. The other ways in MuJoCo are worse: a joint's ``frictionloss``
follows the tension only if Python rewrites it between steps, and as a soft constraint it creeps
under any load; so does the friction of contacts. What remains is the price of inertia: the springs
between beads are explicit in MuJoCo, and the step has to resolve the fastest bead
(`Chain.longest_timestep`, which falls with √mass/n). `docs/routes.md` has wall time and accuracy.

Equations: docs/theory.md, section 5.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import mujoco
import numpy as np

from tendon_mj import add_friction, add_sensor, add_sites, add_tendon, arc_points

Drive = Literal["tension", "displacement"]
_SENSED = {"input": "input_displacement", "output": "output_displacement"}


@dataclass(frozen=True, kw_only=True)
class Chain:
    """Tendon in a sheath as beads between guides; every value is that of the whole tendon.

    Args:
        elements: n, guides; there are n − 1 beads between them and one at each free end.
        friction: μ_d [-].
        static_friction: μ_s ≥ μ_d [-]; None means μ_s = μ_d.
        constant_friction: F_c, tension-independent [N].
        length: L [m].
        bend: L/R, total bend angle [rad].
        axial_stiffness: EA [N].
        pretension: T_0 [N].
        mass: of the tendon, shared evenly [kg].
        damping: Σ c_i of the tendon, shared evenly [N s/m].
        output_stiffness: k_se of the output end [N/m]; inf: fixed.
        timestep: [s]; None takes half of ``longest_timestep``.
    """

    elements: int = 16
    friction: float = 0.15
    static_friction: float | None = None
    constant_friction: float = 0.0
    length: float = 0.5
    bend: float = np.pi
    axial_stiffness: float = 20e3
    pretension: float = 20.0
    mass: float = 0.05
    damping: float = 20.0
    output_stiffness: float = math.inf
    timestep: float | None = None

    @property
    def longest_timestep(self) -> float:
        """2/ω of a bead between two held guides [s]: √(m L/EA)/n, beyond which Euler diverges."""
        return math.sqrt(self.mass * self.length / self.axial_stiffness) / self.elements

    @property
    def step(self) -> float:
        """Time step of the model [s]."""
        return 0.5 * self.longest_timestep if self.timestep is None else self.timestep

    @property
    def output_is_fixed(self) -> bool:
        """Whether the output end is fixed."""
        return math.isinf(self.output_stiffness)


def build_chain(chain: Chain, drive: Drive = "tension") -> mujoco.MjSpec:
    """Build the chain along an arc as an editable model.

    Actuator ``reel``: T_in on the bead at the input end [N] for a driven tension, which that end
    then follows, or ξ_in wound in [m]. Sensors ``input_tension``, ``output_tension`` [N],
    ``input_displacement`` [m] and, on a spring, ``output_displacement`` [m]; plugin instances
    ``sheath_1`` … ``sheath_n``.
    """
    spec = mujoco.MjSpec()
    spec.modelname = "chain"
    spec.option.timestep = chain.step
    spec.option.gravity = [0.0, 0.0, 0.0]
    n = chain.elements
    points = arc_points(chain.length, chain.bend, n)
    guides = add_sites(spec, "guide", points[1:-1])
    spots = np.vstack([points[0], 0.5 * (points[1:-2] + points[2:-1]), points[-1]])
    toward = points[:-1] - points[1:]
    toward /= np.linalg.norm(toward, axis=1)[:, None]
    beads = [_add_bead(spec, chain, i, spots[i], toward[i], drive) for i in range(n + 1)]
    for i, guide in enumerate(guides):
        name = f"tendon_{i + 1}"
        add_tendon(spec, name, [beads[i], guide, beads[i + 1]])
        first, last = i == 0, i == n - 1
        kinds = ["input_tension"] * first + ["output_tension"] * last
        wound = first and drive == "displacement"
        add_friction(
            spec,
            name,
            friction=chain.friction,
            static_friction=chain.static_friction,
            constant_friction=chain.constant_friction / n,
            axial_stiffness=chain.axial_stiffness,
            pretension=chain.pretension,
            name=f"sheath_{i + 1}",
            reel="reel" if wound else None,
            sensors=kinds,
        )
        if wound:
            add_sensor(spec, "sheath_1", "reel_displacement", "input_displacement")
    return spec


def _add_bead(
    spec: mujoco.MjSpec,
    chain: Chain,
    index: int,
    spot: np.ndarray,
    axis: np.ndarray,
    drive: Drive,
) -> str:
    """Add a bead and the site on it, or the site alone where the tendon's end is held."""
    n = chain.elements
    name = {0: "input", n: "output"}.get(index, f"bead_{index}")
    fixed = (index == 0 and drive == "displacement") or (index == n and chain.output_is_fixed)
    if fixed:
        spec.worldbody.add_site(name=name, pos=spot)
        return name
    share = (0.5 if index in (0, n) else 1.0) / n
    body = spec.worldbody.add_body(name=name, pos=spot)
    joint = body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis)
    joint.damping[0] = chain.damping * share
    body.add_geom(size=[0.002, 0.0, 0.0], mass=chain.mass * share, contype=0, conaffinity=0)
    body.add_site(name=name)
    if index == n:
        joint.stiffness[0] = chain.output_stiffness
        joint.springref = -chain.pretension / chain.output_stiffness
    if index == 0:
        motor = spec.add_actuator(name="reel", trntype=mujoco.mjtTrn.mjTRN_JOINT, target=name)
        motor.gainprm[0] = 1.0
    if index in (0, n):
        spec.add_sensor(
            name=_SENSED[name],
            type=mujoco.mjtSensor.mjSENS_JOINTPOS,
            objtype=mujoco.mjtObj.mjOBJ_JOINT,
            objname=name,
        )
    return name
