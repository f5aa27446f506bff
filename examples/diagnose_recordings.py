"""Diagnose a pair of recordings: what does the model of the rig lack?

The recordings are made here, by the package's model `bench` with an effect that the diagnosis is
not told of: a play of 40 µm at the input, as of a worn coupling (backlash). Recordings of your own
rig are read by `tendon_mj.read_recording("rig.csv")`.
"""

import numpy as np

import tendon_mj
from tendon_mj import Measured, Recording, Uncertain

NOISE = 0.05  # of the tension sensor [N]
TRUTH = {"sheath.friction": 0.2, "sheath.backlash": 40e-6}


def record(name, frequency, seed):
    """Three seconds of a rig that moves to and fro."""
    time = np.arange(0.0, 3.0, 0.01)
    described = {
        "name": name,
        "model": "bench",
        "source": "simulated by examples/diagnose_recordings.py",
        "time": time,
        "drive": {"input_displacement_m": "reel"},
        "measured": {"output_tension_N": Measured("output_tension", NOISE)},
        "uncertain": {"sheath.friction": Uncertain(0.15, 0.05, 0.4)},
    }
    reel = 1e-3 * np.sin(2.0 * np.pi * frequency * time) * np.minimum(1.0, time)
    columns = {"input_displacement_m": reel, "output_tension_N": np.zeros(len(time))}
    answer = tendon_mj.replay_recording(Recording(columns=columns, **described), parameters=TRUTH)
    noise = np.random.default_rng(seed).normal(0.0, NOISE, len(time))
    columns["output_tension_N"] = answer.columns["output_tension_N"] + noise
    return Recording(columns=columns, **described)


found = tendon_mj.diagnose([record("slow", 0.7, 0)], [record("fast", 1.1, 1)])
print(found.sentence)
for name, number in {**found.calibrated, **found.parameters}.items():
    print(
        f"{name} = {number.value:.3g}{number.suffix}, 95 % within {number.low:.3g} to "
        f"{number.high:.3g}; it was {TRUTH[name]:.3g}"
    )
print(
    f"error on the recording that was held out: {found.held_out.before:.2f} before, "
    f"{found.held_out.after:.2f} after, in units of the noise of {NOISE} N"
)
