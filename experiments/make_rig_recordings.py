"""Makes the recordings of the page "Your rig in 20 minutes": `models/rig/triangles`, `sines`,
and those of its second rig, `wrist`, `wrist_sines`.

`python -m experiments.make_rig_recordings`. They are simulated, not measured: 48 lumped elements of
`experiments.references`, an independent reference without any code of the plugin, on the lever's
inertia, spring and damper. The cause that is to be found: the bracket that holds the sheath at the
motor yields by `MOUNT`. The sheath's friction and the cable's pretension are not what the
description guesses either, and every reading has noise. The second rig is simulated by
`experiments.one_capstan`.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from experiments import one_capstan
from experiments.references import Carriage, Effects, simulate_effects, uniform_chain
from tendon_mj.typing import FloatArray

# of the rig, as drawn and measured on it
LENGTH, BEND, AXIAL_STIFFNESS = 0.6, np.pi, 4000.0  # of the cable in its sheath [m], [rad], [N]
PULLEY, SPOOL = 0.015, 0.010  # radii [m]
SPRING, DAMPING, INERTIA = 0.3, 0.01, 0.00035766  # of the lever [N m/rad], [N m s/rad], [kg m²]
# guesses of a description
STATED_FRICTION, STATED_PRETENSION = 0.12, 15.0
# true values
FRICTION, PRETENSION = 0.10, 15.6  # [-], [N]
MOUNT = 6e-5  # the cause: yield of the bracket per tension [m/N]
ELEMENTS = 48
MASS = 1e-5  # of the cable, so light that it does not matter [kg]
RATE = 50.0  # samples per second
REST = 0.5  # before the motion [s]
NOISE_ANGLE, NOISE_TENSION = 0.15, 0.05  # [deg], [N]
SEED = 20
FOLDER = Path(__file__).parents[1] / "models" / "rig"


def triangles() -> tuple[FloatArray, FloatArray]:
    """Time [s] and spool angle [deg]: straight lines between turning points, large and small."""
    turns, speed = np.array([0.0, 40.0, -30.0, 40.0, 0.0, 30.0, 10.0, 25.0, -25.0, 0.0]), 60.0
    corners = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(turns)) / speed)])
    time = np.arange(0.0, REST + corners[-1], 1.0 / RATE)
    return time, np.interp(time - REST, corners, turns)


def sines() -> tuple[FloatArray, FloatArray]:
    """Time [s] and spool angle [deg]: two sines of other sizes and speeds."""
    time = np.arange(0.0, REST + 6.0, 1.0 / RATE)
    moved = np.maximum(time - REST, 0.0)
    return time, 20.0 * np.sin(2.2 * moved) + 14.0 * np.sin(5.1 * moved)


def measure(
    time: FloatArray, spool: FloatArray, random: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Tension at the motor [N] and angle of the lever [deg], with noise, (n,) each."""
    chain = uniform_chain(
        ELEMENTS,
        length=LENGTH,
        bend_angle=BEND,
        axial_stiffness=AXIAL_STIFFNESS,
        pretension=PRETENSION,
        static_friction=FRICTION,
        mass=MASS,
    )
    lead = np.arange(-0.5, 0.0, 1.0 / RATE)
    run = simulate_effects(
        chain,
        Effects(sheath_compliance=MOUNT, axial_stiffness=AXIAL_STIFFNESS),
        np.concatenate([lead, time]),
        np.concatenate([0.0 * lead, SPOOL * np.radians(spool)]),
        carriages=[
            Carriage(
                mass=INERTIA / PULLEY**2,
                stiffness=SPRING / PULLEY**2,
                damping=DAMPING / PULLEY**2,
            )
        ],
        preload=STATED_PRETENSION,
    )
    after = slice(len(lead), None)
    tension = run.input_tension[after] + random.normal(0.0, NOISE_TENSION, time.size)
    lever = np.degrees(run.output_displacement[after] / PULLEY)
    return tension, lever + random.normal(0.0, NOISE_ANGLE, time.size)


def write(name: str, header: str, *columns: FloatArray) -> None:
    """Write a CSV of times [s], angles and readings, rounded as a logger does."""
    rows = zip(np.round(1e3 * columns[0]), *columns[1:], strict=True)
    lines = [
        ",".join([f"{t:.0f}", f"{motor:.2f}", *(f"{f:.3f}" for f in forces), f"{angle:.2f}"])
        for t, motor, *forces, angle in rows
    ]
    path = FOLDER / f"{name}.csv"
    path.write_text("\n".join([header, *lines]) + "\n", encoding="utf-8")
    print(path)


def main() -> None:
    """Simulate both motions of both rigs, and write a CSV of each."""
    random = np.random.default_rng(SEED)
    for motion in (triangles, sines):
        time, spool = motion()
        header = "time_ms,spool_deg,cable_N,lever_deg"
        write(motion.__name__, header, time, spool, *measure(time, spool, random))
    for name, motion in (("wrist", one_capstan.triangles), ("wrist_sines", one_capstan.sines)):
        time, motor = motion()
        readings = one_capstan.noisy(one_capstan.simulate(time, motor), random)
        header = "time_ms,motor_deg,agonist_N,antagonist_N,wrist_deg"
        write(name, header, time, motor, *readings.T)


if __name__ == "__main__":
    main()
