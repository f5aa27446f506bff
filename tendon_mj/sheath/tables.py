"""The two tables that hold a tendon at one moment, a row a quantity, a column a segment or guide.

Guide i sits between segment i (input side) and segment i+1 (output side). Tensions are normalised,
τ = T/EA. Tables, rather than an argument for each quantity, keep compiled calls short.
"""

from __future__ import annotations

from typing import Any

# Rows over the n+1 segments.
(
    LENGTH,  # ℓ, geometric length [m]
    GIVE,  # g, length that an elastic support at the end gives up per unit τ [m]
    OFFSET,  # d, part of the strain that no tension causes (damping, creep, stiffening) [-]
    SHARE,  # a, strain that comes with unit τ; 1 for a purely elastic tendon [-]
    STORED,  # s⁻, unstretched length before the step [m]
    TENSION,  # τ, a guess on entry, the result on return [-]
    ALONE,  # work space of the sweep
    SEGMENT_ROWS,
) = range(8)

# Rows over the n guides.
(
    STATIC,  # e^{μ_s φ}, largest τ_i/τ_{i+1} at rest [-]
    DYNAMIC,  # e^{μ_d φ}, that ratio while sliding to the input [-]
    BACK_STATIC,  # largest τ_{i+1}/τ_i at rest, another one where friction knows directions [-]
    BACK_DYNAMIC,  # that ratio while sliding to the output [-]
    CONSTANT,  # tension-independent friction over EA [-]
    DRAG,  # D, tension over EA that a flow of 1 m in this step takes (viscosity, inertia) [1/m]
    PUSH,  # b, the part of it that does not depend on this step's flow (momentum) [-]
    WAS,  # direction of flow in the step before: +1 to the input, −1, 0 at rest
    UP,  # largest τ_i/τ_{i+1} that holds now
    DOWN,  # largest τ_{i+1}/τ_i that holds now
    FLOW,  # unstretched length that passes towards the input in this step [m], result
    SLIP,  # direction of that flow, result
    GUIDE_ROWS,
) = range(13)

# What rounding leaves uncertain of a strain, and so of τ, when it is the difference ℓ/s − 1.
ROUNDING = 5e-16

# Both tables are float64 arrays of shapes (SEGMENT_ROWS or more, n+1) and
# (GUIDE_ROWS or more, n).
Table = Any
