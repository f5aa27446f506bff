"""One case: an effect is hidden, and slow motion of one amplitude is all that was recorded."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from experiments.hidden_effects.hidden import EFFECTS, PARAMETERS, HiddenEffect
from experiments.hidden_effects.references import COLUMNS, ReferenceBench
from experiments.hidden_effects.strengths import calibration_projector, find_strength
from experiments.next_experiment.rig import (
    FRICTION,
    KNOWN,
    NOISE,
    Description,
    poor_drive,
    record,
)
from tendon_mj.lab.recordings import Recording
from tendon_mj.typing import FloatArray

RATIOS = 2.0, 3.0  # of the residual that the effect leaves to the noise
AMPLITUDES = 0.5e-3, 0.45e-3  # of the training and of the held-out recording [m]
TRUE_FRICTION = 0.2
PERTURBATION = 1.01  # factor on the friction, to find the sensitivity to it
# they leave next to nothing where a displacement is prescribed slowly
INVISIBLE = ("static_friction", "tendon_inertia")
HIDDEN = [name for name in (*EFFECTS, *PARAMETERS) if name not in INVISIBLE]
MOTIONS = ("sine", "triangle")
SENSORS = {"output": COLUMNS[1:], "both": COLUMNS}


@dataclass(frozen=True, kw_only=True)
class Case:
    """The hidden effects, and the recordings.

    Attributes:
        hidden: name of the effect or parameter. motion: of the drive. sensors: which were read.
        ratio: of the residual that it leaves to the noise, as wanted. seed: of all random draws.
    """

    hidden: str
    motion: str
    sensors: str
    ratio: float
    seed: int

    @property
    def name(self) -> str:
        """Of its file."""
        return f"{self.hidden}_{self.motion}_{self.sensors}_{self.ratio:g}_{self.seed}"

    @property
    def random(self) -> np.random.Generator:
        """Random numbers of this case, from their beginning."""
        drawn = f"{self.hidden}_{self.motion}_{self.sensors}_{self.seed}"  # alike at each ratio
        return np.random.default_rng([self.seed, *drawn.encode()])


@dataclass(frozen=True, kw_only=True)
class HiddenRig:
    """A rig that hides an effect, and its first recordings."""

    truth: ReferenceBench
    ratio: float
    train: Recording
    held_out: Recording


def make(case: Case) -> HiddenRig:
    """Draw the effect, find the strength at which it leaves the ratio, and record."""
    random, sensors = case.random, SENSORS[case.sensors]
    parameter = case.hidden in PARAMETERS
    known = {n: v for n, v in KNOWN.items() if n != f"sheath.{case.hidden}"}
    calibrates = case.hidden not in ("friction", "bend_angle")  # only their product shows
    described = Description(
        sensors=sensors,
        known=known,
        uncertain={"sheath.friction": FRICTION} if calibrates else {},
    )
    sound = ReferenceBench(friction=TRUE_FRICTION if calibrates else ReferenceBench.friction)
    hidden = _drawn(case.hidden, parameter, sound, sensors, random)
    drives = [poor_drive(case.motion, amplitude) for amplitude in AMPLITUDES]
    rows = [COLUMNS.index(column) for column in sensors]

    def residual(rig: ReferenceBench) -> FloatArray:
        one, other = (r.simulate(drives[:1], fine=False)[0][rows] for r in (rig, sound))
        return np.asarray((one - other).ravel() / NOISE, float)

    stiffer = dataclasses.replace(sound, friction=PERTURBATION * sound.friction)
    left = calibration_projector([residual(stiffer)] if calibrates else [])
    result = find_strength(
        lambda strength: float(
            np.sqrt(np.mean(left(residual(hidden.apply(sound, strength))) ** 2))
        ),
        case.ratio,
        hidden.low,
        hidden.high,
        hidden.start,
    )
    truth = hidden.apply(sound, result.strength)
    made = [
        record(truth, name, drive, described, random)
        for name, drive in zip(("slow", "held_out"), drives, strict=True)
    ]
    return HiddenRig(truth=truth, ratio=result.ratio, train=made[0], held_out=made[1])


def _drawn(
    name: str,
    parameter: bool,
    rig: ReferenceBench,
    sensors: tuple[str, ...],
    random: np.random.Generator,
) -> HiddenEffect[ReferenceBench]:
    """The effect; of a sensor, one that was read."""
    draw = (PARAMETERS if parameter else EFFECTS)[name]
    while True:
        hidden = draw(random)
        if hidden.apply(rig, hidden.start).sensors.keys() <= set(sensors):
            return hidden
