"""Sessions of one rig: the differences between its recordings, and what these state of it."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from experiments.hidden_effects.references import R
from experiments.hidden_effects.strengths import PERTURBATION, Trial, rms, simulate_each
from tendon_mj.lab.recordings import Session
from tendon_mj.typing import FloatArray

REPRODUCIBILITY = (3.0, 5.0)  # difference between sessions, rms in effect [noise]
LARGEST = 2.0  # standard deviations
UNSEEN_FRICTION = 0.1  # standard deviation of a friction that is itself hidden [-]
GUESS = math.log(2.0)  # by which a stated spread is wrong at most, either way
BENDS = 1.2  # largest change of the sheath's bend [rad]


@dataclass(frozen=True, kw_only=True)
class RigState:
    """Changes of a rig that hold in one recording; by default there are none.

    Attributes:
        extra_bend: of the sheath [rad], which the recording states as known.
        pretension: above the mean of all sessions [N]; the recording states its spread.
        zeros: of each sensor [its unit]; likewise.
        friction: share of the friction above its mean [-], of which no recording tells.
    """

    extra_bend: float = 0.0
    pretension: float = 0.0
    zeros: tuple[float, ...] = ()
    friction: float = 0.0

    def bent(self, reference: R) -> R:
        """The reference in this recording's bend, everything else as in all others."""
        if self.extra_bend == 0.0:
            return reference
        return dataclasses.replace(reference, bend=reference.bend + self.extra_bend)

    def set_anew(self, reference: R) -> R:
        """The reference with this recording's pretension and friction."""
        return dataclasses.replace(
            reference,
            pretension=reference.pretension + self.pretension,
            friction=reference.friction * (1.0 + self.friction),
        )

    def parameters(self, reference: R) -> dict[str, float]:
        """True values in this recording of the model's parameters, where they differ from others.

        Args:
            reference: with the hidden effects, in no particular recording.
        """
        own, stated = self.set_anew(reference), reference.description
        sheath = {
            "friction": own.friction,
            "pretension": own.pretension,
            "extra_bend": self.extra_bend,
        }
        offsets = zip(stated.sensors.values(), self.zeros, strict=True)
        return {f"{s}.{name}": value for s in stated.sheaths for name, value in sheath.items()} | {
            f"{sensor}.offset": zero for sensor, zero in offsets
        }

    def read(self, readings: FloatArray) -> FloatArray:
        """Readings (sensors, samples) with this recording's zeros."""
        return readings + np.array(self.zeros)[:, None] if self.zeros else readings


@dataclass(frozen=True, kw_only=True)
class Sessions:
    """State of the rig in every recording.

    Attributes:
        states: of the training recordings, then of those held out.
        stated: parameter → mean and spread, as the recordings state them.
    """

    states: tuple[RigState, ...]
    stated: Mapping[str, Session]

    @classmethod
    def one(cls, count: int) -> Sessions:
        """All of ``count`` recordings in one session."""
        return cls(states=(RigState(),) * count, stated={})


def draw_bends(count: int, rng: np.random.Generator) -> list[float]:
    """Change of the sheath's bend in each of ``count`` recordings [rad]."""
    return [float(bend) for bend in np.round(rng.uniform(-BENDS, BENDS, count), 2)]


def draw_sessions(trial: Trial[R], bends: Sequence[float], rng: np.random.Generator) -> Sessions:
    """Draw friction, pretension and zeros of every recording, each of about the same effect.

    Args:
        trial: training recordings with nothing that differs but the bend.
        bends: extra bend of the training recordings, then of those held out [rad].
        rng: of everything.
    """
    reference, stated = trial.references[0], trial.references[0].description
    share: float = rng.uniform(*REPRODUCIBILITY) / math.sqrt(
        3.0
    )  # of friction, pretension and zeros
    per_friction = rms(trial.sensitivity("friction")) / (PERTURBATION - 1.0)
    friction = share / per_friction if per_friction > 0.0 else UNSEEN_FRICTION
    per_newton = rms(trial.pretension_sensitivity) / ((PERTURBATION - 1.0) * reference.pretension)
    spreads = [share / per_newton, *(share * trial.noise)]

    deviations = np.clip(rng.standard_normal((len(bends), 1 + len(spreads))), -LARGEST, LARGEST)
    states = tuple(
        RigState(
            extra_bend=bend,
            friction=float(friction * row[0]),
            pretension=float(spreads[0] * row[1]),
            zeros=tuple(float(s * z) for s, z in zip(spreads[1:], row[2:], strict=True)),
        )
        for bend, row in zip(bends, deviations, strict=True)
    )
    zeros: list[float]
    guesses = np.exp(rng.uniform(-GUESS, GUESS, len(spreads)))
    mounted, *zeros = (float(f"{s * g:.2g}") for s, g in zip(spreads, guesses, strict=True))
    mean = float(f"{reference.pretension:.3g}")
    pretensions = {f"{sheath}.pretension": Session(mean, mounted) for sheath in stated.sheaths}
    offsets = {
        f"{sensor}.offset": Session(0.0, zero)
        for sensor, zero in zip(stated.sensors.values(), zeros, strict=True)
    }
    return Sessions(states=states, stated=pretensions | offsets)


def reproducibility(trial: Trial[R], sessions: Sessions) -> tuple[float, float]:
    """Rms by which sessions differ, with nothing hidden [noise]: in all, and once calibrated."""
    states = sessions.states[: len(trial.drives)]
    references = [s.set_anew(r) for s, r in zip(states, trial.references, strict=True)]
    readings = simulate_each(references, trial.drives, fine=False)
    residual = trial.of([s.read(r) for s, r in zip(states, readings, strict=True)])
    return rms(residual), rms(trial.uncalibrated(residual))
