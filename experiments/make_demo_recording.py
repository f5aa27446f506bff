"""Makes the example recording of the package: `models/bench/recordings/twin.csv`.

`python -m experiments.make_demo_recording`. The recording is simulated, not measured: 64 lumped
elements of `experiments.references`, an independent reference that shares no code with the plugin,
with mass and stick-slip and the parameters of the bench, driven slowly through two large cycles and
a few minor loops, with sensor noise added.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from experiments.references import quasi_static, simulate_chain, uniform_chain
from tendon_mj.lab.recordings import Measured, Recording, Uncertain, write_recording
from tendon_mj.models import Bench

RATE = 50.0  # samples per second
SPEED = 0.5e-3  # of the input [m/s]
# of ξ_in [m]
TURNING_POINTS = (0.0, 2e-3, -1.5e-3, 2e-3, 0.5e-3, 1.4e-3, -0.8e-3, 0.2e-3, -1.5e-3, 0.0)
NOISE = 0.05  # of both tension sensors [N]
SEED = 1991
FOLDER = Path(__file__).parents[1] / "models" / "bench" / "recordings"


def displacement() -> tuple[np.ndarray, np.ndarray]:
    """Time [s] and input displacement [m]: straight lines between the turning points."""
    corners = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(TURNING_POINTS)) / SPEED)])
    time = np.arange(0.0, corners[-1], 1.0 / RATE)
    return time, np.interp(time, corners, TURNING_POINTS)


def main() -> None:
    """Simulate the elements and write the recording."""
    bench = Bench()
    time, reel = displacement()
    chain = uniform_chain(
        64,
        length=bench.length,
        bend_angle=bench.bend,
        axial_stiffness=bench.axial_stiffness,
        pretension=bench.pretension,
        static_friction=bench.friction,
        environment_stiffness=bench.environment_stiffness,
        sensor_stiffness=bench.sensor_stiffness,
    )
    run = simulate_chain(quasi_static(chain, 4.0, slowness=300.0), time, input_displacement=reel)
    random = np.random.default_rng(SEED)
    noisy = {
        name: np.round(tension + random.normal(0.0, NOISE, len(time)), 3)
        for name, tension in (
            ("input_tension_N", run.input_tension),
            ("output_tension_N", run.output_tension),
        )
    }
    recording = Recording(
        name="twin",
        model="bench",
        source=(
            "made by tendon-mj, not measured: experiments/make_demo_recording.py, lumped elements, "
            f"noise {NOISE} N, seed {SEED}; Apache-2.0"
        ),
        time=np.round(time, 6),
        columns={"input_displacement_m": np.round(reel, 9), **noisy},
        drive={"input_displacement_m": "reel"},
        measured={
            "input_tension_N": Measured("input_tension", NOISE),
            "output_tension_N": Measured("output_tension", NOISE),
        },
        known={"sheath.axial_stiffness": bench.axial_stiffness},
        uncertain={"sheath.friction": Uncertain(bench.friction, 0.05, 0.4)},
    )
    FOLDER.mkdir(exist_ok=True)
    print(write_recording(recording, FOLDER / "twin.csv"))


if __name__ == "__main__":
    main()
