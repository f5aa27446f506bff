"""Run a chain of elements on an input history, with its energy balance.

Equations: docs/theory.md, section 5.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from experiments.references.chain_integrator import COLUMNS, element_system, march
from experiments.references.checks import History, drive, step_counts, vector
from experiments.references.elements import ElementChain
from tendon_mj.typing import FloatArray


@dataclass(frozen=True, eq=False)
class EnergyBalance:
    """Energies and works of a run, each of the shape of its ``time``.

    Args:
        elastic: ½ Σ T_j²/k_j of tendon, environment and sensor [J].
        kinetic: ½ Σ m_i ξ̇_i² [J].
        input_work: ∫ T_in dξ_in so far [J].
        friction_work: lost to friction so far, never falling [J].
        damping_work: ∫ Σ c_i ξ̇_i² dt so far, never falling [J].
    """

    elastic: FloatArray
    kinetic: FloatArray
    input_work: FloatArray
    friction_work: FloatArray
    damping_work: FloatArray

    @property
    def stored(self) -> FloatArray:
        """Elastic and kinetic energy gained since the start [J]."""
        total = self.elastic + self.kinetic
        gained: FloatArray = total - total[0]
        return gained

    @property
    def dissipated(self) -> FloatArray:
        """Work of friction and damping so far [J]."""
        return self.friction_work + self.damping_work

    @property
    def error(self) -> float:
        """Largest |input work − stored − dissipated| over the largest of the three [–]."""
        size = max(float(np.abs(e).max()) for e in (self.input_work, self.stored, self.dissipated))
        gap = float(np.abs(self.input_work - self.stored - self.dissipated).max())
        return gap / size if size > 0.0 else gap


@dataclass(frozen=True, eq=False)
class ChainState:
    """Where the elements are and how fast they move; zero is the tendon at rest under T_0.

    Args:
        displacement: ξ_i [m], positive toward the actuator. Shape (n,).
        velocity: ξ̇_i [m/s]; exactly 0 is at rest. Shape (n,).
    """

    displacement: FloatArray
    velocity: FloatArray


@dataclass(frozen=True, eq=False)
class ChainRun:
    """Result of `simulate_chain`; histories have the shape of ``time``.

    Args:
        time: as given [s].
        input_tension: T_in [N].
        output_tension: T_out = T_{n+1} [N].
        input_displacement: ξ_in [m]. Where T_in is prescribed it is the one of a taut tendon.
        output_displacement: ξ_out = (T_out − T_0)/k_se [m].
        energy: energies and works.
        element_friction_work: lost to friction by each element over the whole run [J]. Shape (n,).
        element_displacement: ξ_i at each sample [m], shape (samples, n); no rows unless asked for.
        state: of the elements at the end.
        steps: number of steps taken.
        unsolved_steps: steps whose equations were not solved within the iterations allowed; 0
            unless something is badly scaled. They show in ``energy.error``.
    """

    time: FloatArray
    input_tension: FloatArray
    output_tension: FloatArray
    input_displacement: FloatArray
    output_displacement: FloatArray
    energy: EnergyBalance
    element_friction_work: FloatArray
    element_displacement: FloatArray
    state: ChainState
    steps: int
    unsolved_steps: int


def simulate_chain(
    chain: ElementChain,
    time: npt.ArrayLike,
    *,
    input_tension: npt.ArrayLike | None = None,
    input_displacement: npt.ArrayLike | None = None,
    time_step: float | None = None,
    state: ChainState | None = None,
    record_elements: bool = False,
) -> ChainRun:
    """Integrate eq. (25) of the paper with stick and slip through an input history.

    The method is the energy-conserving implicit midpoint rule with exact sticking, of order 2
    if no element stops or starts; `chain_integrator` has the details.

    Args:
        chain: the elements.
        time: instants of the input [s], rising. Shape (samples,), at least 2.
        input_tension: T_in [N], ≥ 0, linear between instants. A number or of ``time``'s shape.
        input_displacement: ξ_in [m], linear between instants; exactly one of the two inputs. It
            needs a finite ``chain.input_stiffness``.
        time_step: longest step [s], > 0; None is ``chain.time_step``. Steps divide the time between
            two instants evenly. A slow run with μ_s = μ_d may take 4 times that, not 20 times.
        state: to start from; None is at rest under uniform T_0.
        record_elements: keep every element's displacement at every instant.

    Raises:
        InvalidValueError: no input or two.
    """
    instants = vector(time)
    counts = step_counts(instants, time_step or chain.time_step)
    history, tension_driven = drive(input_tension, input_displacement, instants.size)
    start = state or ChainState(np.zeros(chain.n), np.zeros(chain.n))
    system = element_system(chain, start.displacement, start.velocity, tension_driven)
    record = np.zeros((instants.size, COLUMNS))
    positions = np.zeros((instants.size if record_elements else 0, chain.n))
    unsolved = march(system, History(instants, history, counts), record, positions)
    columns = np.ascontiguousarray(record.T)
    return ChainRun(
        time=instants,
        input_tension=columns[0],
        output_tension=columns[1],
        input_displacement=columns[2],
        output_displacement=columns[3],
        energy=EnergyBalance(*columns[4:]),
        element_friction_work=system.elements["friction_work"].copy(),
        element_displacement=positions,
        state=ChainState(
            system.elements["displacement"].copy(), system.elements["velocity"].copy()
        ),
        steps=int(counts.sum()),
        unsolved_steps=int(unsolved),
    )
