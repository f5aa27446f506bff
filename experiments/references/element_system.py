"""A chain of elements as the compiled functions take it: parameters, and records of its state.

Spring j lies before element j + 1, the last one behind the last element. Displacements are positive
toward the input. Each element and each spring is one record of an array, whose named fields Numba
compiles to plain memory.

Equations: docs/theory.md, section 5.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt

from experiments.references.elements import ElementChain
from tendon_mj.typing import FloatArray

RecordArray = npt.NDArray[np.void]

ELEMENT: Final = np.dtype(
    [
        ("mass", np.float64),  # m_i [kg]
        ("damping", np.float64),  # c_i [N s/m]
        ("static_pulled", np.float64),  # friction per unit of T_i up to which it rests [–]
        ("static_loosened", np.float64),
        ("dynamic_pulled", np.float64),  # friction per unit of T_i while it slides [–]
        ("dynamic_loosened", np.float64),
        ("force", np.float64),  # f_i [N]
        ("rubs", np.bool_),  # has friction of either kind
        ("displacement", np.float64),  # ξ_i [m]
        ("velocity", np.float64),  # ξ̇_i [m/s]
        ("friction_work", np.float64),  # so far [J]
        ("increment", np.float64),  # d_i, displacement within the step [m]
        ("direction", np.int64),  # of sliding, +1 toward the input, 0 at rest
        ("held", np.bool_),  # was stopped in this step
        ("inertia", np.float64),  # force of inertia and damping per d_i [N/m]
        ("momentum", np.float64),  # force of inertia per −v_i [kg/s]
        ("lower", np.float64),  # of the tridiagonal system for d [N/m]
        ("diagonal", np.float64),
        ("upper", np.float64),
        ("load", np.float64),  # its right side [N]
    ]
)
SPRING: Final = np.dtype(
    [
        ("stiffness", np.float64),  # k_j [N/m]
        ("tension", np.float64),  # at the start of the step, below 0 where slack [N]
        ("mean", np.float64),  # T̄_j over the step [N]
        ("slope", np.float64),  # its derivative in the elongation [N/m]
    ]
)


class ElementSystem(NamedTuple):
    """Chain of elements in the state it has reached.

    Attributes:
        pretension: T_0 [N].
        output_stiffness: k_se [N/m].
        tension_driven: whether T_in is prescribed, else ξ_in.
        elements: of type ``ELEMENT``. Shape (n,).
        springs: of type ``SPRING``. Shape (n + 1,).
    """

    pretension: float
    output_stiffness: float
    tension_driven: bool
    elements: RecordArray
    springs: RecordArray


def element_system(
    chain: ElementChain, displacement: FloatArray, velocity: FloatArray, tension_driven: bool
) -> ElementSystem:
    """Return a chain whose elements are at ``displacement`` [m] with ``velocity`` [m/s]."""
    elements = np.zeros(chain.n, dtype=ELEMENT)
    static = chain.friction_weights(chain.static_friction)
    dynamic = chain.friction_weights(chain.dynamic_friction)
    for name, values in {
        "mass": chain.mass,
        "damping": chain.damping,
        "static_pulled": static[0],
        "static_loosened": static[1],
        "dynamic_pulled": dynamic[0],
        "dynamic_loosened": dynamic[1],
        "force": chain.friction_force,
        "rubs": (static[0] > 0.0) | (chain.friction_force > 0.0),
        "displacement": displacement,
        "velocity": velocity,
    }.items():
        elements[name] = values
    springs = np.zeros(chain.n + 1, dtype=SPRING)
    springs["stiffness"] = chain.spring_stiffness
    return ElementSystem(
        pretension=float(chain.pretension),
        output_stiffness=float(chain.output_stiffness),
        tension_driven=tension_driven,
        elements=elements,
        springs=springs,
    )
