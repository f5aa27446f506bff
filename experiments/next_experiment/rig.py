"""The rig that hides an effect: the reference of the bench, and the experiments it allows."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from experiments.hidden_effects.references import COLUMNS, ReferenceBench
from tendon_mj.lab.experiment import DriveBounds, ExperimentBounds
from tendon_mj.lab.recordings import Measured, Recording, Uncertain
from tendon_mj.typing import FloatArray

DRIVE = "input_displacement_m"
NOISE = 0.2  # of each tension [N]
RATE = 250.0  # samples per second
DURATION = 6.0  # of every recording [s]
PRETENSION, BEND = "sheath.pretension", "sheath.extra_bend"
KNOWN = {
    "sheath.axial_stiffness": 2e4,
    "environment.stiffness": 1e4,
    "sensor.stiffness": 4e4,
    PRETENSION: 20.0,
}
FRICTION = Uncertain(0.15, 0.05, 0.4)
STATES = {PRETENSION: (10.0, 40.0), BEND: (0.0, 2.0)}  # that the user can set
LOWEST, HIGHEST = 1.0, 150.0  # reading that a user allows [N]


@dataclass(frozen=True, kw_only=True)
class Description:
    """Statements of a rig's recordings.

    Attributes:
        sensors: measured columns.
        known: parameter → value.
        uncertain: parameter → range.
    """

    sensors: tuple[str, ...]
    known: Mapping[str, float]
    uncertain: Mapping[str, Uncertain]

    @property
    def bounds(self) -> ExperimentBounds:
        """Experiments open to the user: no state is set whose value is itself in doubt."""
        return ExperimentBounds(
            drive={DRIVE: DriveBounds(-1.0e-3, 1.3e-3, 12e-3, 1.0)},
            states={n: s for n, s in STATES.items() if n == BEND or n in self.known},
            limits=dict.fromkeys(self.sensors, (LOWEST, HIGHEST)),
            measure={c: _measured(c) for c in COLUMNS if c not in self.sensors},
        )


def poor_drive(kind: str, amplitude: float) -> FloatArray:
    """Slow motion of one amplitude [m] at one speed of 1 mm/s, a sine or a triangle."""
    time = np.arange(round(DURATION * RATE)) / RATE
    if kind == "sine":
        return amplitude * np.sin(1e-3 / amplitude * time)
    phase = 1e-3 * time / (4.0 * amplitude) + 0.25
    return amplitude * (1.0 - 4.0 * np.abs(phase % 1.0 - 0.5))


def record(
    truth: ReferenceBench,
    name: str,
    drive: FloatArray,
    described: Description,
    random: np.random.Generator,
) -> Recording:
    """A recording of the truth, under the drive, with noise."""
    readings = dict(zip(COLUMNS, truth.simulate([drive])[0], strict=True))
    noisy = {c: readings[c] + random.normal(0.0, NOISE, drive.size) for c in described.sensors}
    return Recording(
        name=name,
        model="bench",
        source="made by tendon-mj, not measured: experiments/next_experiment; Apache-2.0",
        time=np.round(np.arange(drive.size) / RATE, 6),
        columns={DRIVE: np.round(drive, 9), **{c: np.round(v, 4) for c, v in noisy.items()}},
        drive={DRIVE: "reel"},
        measured={c: _measured(c) for c in described.sensors},
        known=described.known,
        uncertain=described.uncertain,
    )


def run(
    truth: ReferenceBench, template: Recording, random: np.random.Generator
) -> Recording | None:
    """Run an experiment on the rig; None if a reading would leave the limits."""
    known = template.known
    state = dataclasses.replace(
        truth,
        pretension=truth.pretension + known.get(PRETENSION, 20.0) - 20.0,
        bend=truth.bend + known.get(BEND, 0.0),
    )
    described = Description(
        sensors=tuple(template.measured), known=known, uncertain=template.uncertain
    )
    recorded = record(state, template.name, template.columns[DRIVE], described, random)
    readings = np.array([recorded.columns[c] for c in described.sensors])
    return recorded if readings.min() >= LOWEST and readings.max() <= HIGHEST else None


def _measured(column: str) -> Measured:
    return Measured(column.removesuffix("_N"), NOISE)
