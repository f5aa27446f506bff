"""State of a rig in one recording: what was set anew for it, and what is not quite the same."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from experiments.hidden_effects.references.bench import ReferenceBench
from experiments.hidden_effects.references.joint import ReferenceJoint
from tendon_mj.typing import FloatArray

R = TypeVar("R", ReferenceBench, ReferenceJoint)


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
            reference: with what is hidden, in no particular recording.
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
