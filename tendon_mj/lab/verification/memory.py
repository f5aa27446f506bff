"""Memory of a simulation, with sheaths and without."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco

_NUMBER = 8  # bytes of a float64


@dataclass(frozen=True)
class Memory:
    """Memory of one simulation [bytes].

    Attributes:
        plugin_state: of all sheaths, within the buffer.
        buffer: what an `MjData` holds between steps and within.
        arena: what it reserves for contacts, constraints and the stack.
        state: a state of kind FULLPHYSICS, as rollouts start from.
    """

    plugin_state: int
    buffer: int
    arena: int
    state: int

    @property
    def total(self) -> int:
        """Buffer and arena [bytes]."""
        return self.buffer + self.arena

    @classmethod
    def of(cls, model: mujoco.MjModel) -> Memory:
        """Memory of a simulation of a model."""
        data = mujoco.MjData(model)
        kind = mujoco.mjtState.mjSTATE_FULLPHYSICS
        return cls(
            plugin_state=_NUMBER * int(model.npluginstate),
            buffer=int(data.nbuffer),
            arena=int(data.narena),
            state=_NUMBER * mujoco.mj_stateSize(model, kind),
        )

    def result(self) -> dict[str, int]:
        """Plain numbers for `result.json`."""
        return {
            "plugin_state": self.plugin_state,
            "buffer": self.buffer,
            "arena": self.arena,
            "total": self.total,
            "state": self.state,
        }
