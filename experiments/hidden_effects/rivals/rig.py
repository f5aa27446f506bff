"""Recordings, simulators, shared terms and the command line of the rivals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from experiments.command import run_experiment
from experiments.hidden_effects.case_folder import Solve, solve_suite
from tendon_mj.errors import RecordingError
from tendon_mj.lab.diagnosis import SystemDescription, Term
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.replay import Simulator
from tendon_mj.typing import FloatArray

Values = Mapping[str, float]

FAILED = 1e3  # residual of a failed simulation [noise]
RANGE = 8.0  # spreads to either side of a session's parameter


class Rig:
    """Recordings of one rig, simulated on one core.

    Args:
        recordings: measured data, with the noise of every column.
        step: of the simulation, times the model's own.
    """

    def __init__(self, recordings: Sequence[Recording], step: float) -> None:
        self.recordings = tuple(recordings)
        self.simulate = Simulator(self.recordings, threads=1).in_steps(step)

    @property
    def base(self) -> dict[str, float]:
        """Parameter → value of the model as described."""
        return {name: parameter.value for name, parameter in self.simulate.parameters.items()}

    def residuals(self, parameter_sets: Sequence[Values]) -> FloatArray:
        """(sets, m) of (simulated − measured)/noise by recording, column and sample."""
        rows = []
        for answers in self.simulate(parameter_sets):
            parts = [
                (series[column] - recording.columns[column]) / noise(recording, column)
                for recording, series in zip(self.recordings, answers, strict=True)
                for column in recording.measured
            ]
            rows.append(np.nan_to_num(np.concatenate(parts), nan=FAILED))
        return np.clip(np.array(rows), -FAILED, FAILED)

    @cached_property
    def owner(self) -> NDArray[np.str_]:
        """(m,) name of the recording of each residual."""
        sizes = [r.time.size * len(r.measured) for r in self.recordings]
        return np.repeat([r.name for r in self.recordings], sizes)

    @property
    def uncertain(self) -> list[Term]:
        """Terms of the uncertain parameters."""
        return [
            Term((name,), "", u.value, u.low, u.high, (u.high - u.low) / 20.0)
            for name, u in self.recordings[0].uncertain.items()
        ]

    @property
    def sessions(self) -> list[Term]:
        """Terms of the session parameters of each recording."""
        return [
            Term(
                targets=(f"{name} @ {recording.name}",),
                unit="",
                inert=own.value,
                low=own.value - RANGE * own.spread,
                high=own.value + RANGE * own.spread,
                probe=0.5 * own.spread,
                spread=own.spread,
            )
            for recording in self.recordings
            for name, own in recording.session.items()
        ]

    def describe(self) -> SystemDescription:
        """The model and the recordings as a catalogue asks for them."""
        parameters, first = self.simulate.parameters, self.recordings[0]
        spans: dict[str, float] = {}
        for recording in self.recordings:
            for column, measured in recording.measured.items():
                span = float(np.ptp(recording.columns[column]))
                spans[measured.sensor] = max(span, spans.get(measured.sensor, 0.0))
        joints = {name.rsplit(".", 1)[0] for name, p in parameters.items() if p.kind == "joint"}
        return SystemDescription(
            values=self.base,
            known=frozenset(first.known),
            uncertain=frozenset({**first.uncertain, **first.session}),
            spans=spans,
            inputs=tuple(name for _, name in first.driven),
            free_joints=tuple(sorted(j for j in joints if not self.simulate.joints.get(j))),
        )


def noise(recording: Recording, column: str) -> float:
    """Noise of a measured column [the column's unit].

    Raises:
        RecordingError: the recording states none.
    """
    stated = recording.measured[column].noise
    if stated is None:
        raise RecordingError(f"recording {recording.name!r}, column {column!r}: states no noise")
    return stated


def run_rival(solve: Solve, name: str) -> int:
    """Run a rival as ``python -m experiments.hidden_effects.rivals.<name>``; return its status."""

    def run(
        *, suite: Path, out: Path, cases: int = 0, processes: int = 1, again: bool = False
    ) -> None:
        """Run a rival on a suite of hidden cases.

        Args:
            suite: folder of cases.
            out: folder for a folder per case with result.json and run.json (seconds, error).
            cases: the first so many only; 0 is all.
            processes: number of worker processes.
            again: run also on cases that already have a result.
        """
        solve_suite(solve, suite, out, cases=cases, again=again, processes=processes)

    return run_experiment(run, f"hidden_effects.rivals.{name}")
