"""Plain numbers of the study, for `result.json`: SI units."""

from __future__ import annotations

from experiments.positioning_system import published
from experiments.positioning_system.study import Study


def result(found: Study) -> dict[str, object]:
    """Nested dictionary of numbers in SI units."""
    position, force = found.measurement.reproducibility()
    stiffness, damping, left = found.measurement.servo_gains()
    return {
        "published": {
            "mass_kg": published.MASS,
            "viscous_Ns_per_m": published.VISCOUS,
            "coulomb_N": published.COULOMB,
            "offset_N": published.OFFSET,
            "servo": {
                "kp_N_per_m": published.SERVO_STIFFNESS,
                "kv_Ns_per_m": published.SERVO_DAMPING,
            },
        },
        "servo": {"kp_N_per_m": stiffness, "kv_Ns_per_m": damping, "left_N": left},
        "reproducibility": {"position_m": position, "motor_force_N": force},
        "described": {
            name: {
                "diagnosis": one.diagnosis.result(),
                "held_out": one.errors,
                "sysid": [fit.result() for fit in one.sysid] if one.sysid else None,
            }
            for name, one in found.described.items()
        },
    }
