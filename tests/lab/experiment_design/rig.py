"""A rig without physics, on which two effects coincide within what was recorded.

Its tension is 20 N, plus a·g_a(x) + b·g_b(x) for a drive x [mm] and shapes g that a test chooses,
plus c·x·p for a pretension p that the user can set. At its input only a is felt.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from tendon_mj.lab.diagnosis import Diagnosis, Effect, diagnose
from tendon_mj.lab.diagnosis.effects.binding import ParameterSpecification, on_sheaths
from tendon_mj.lab.experiment import DriveBounds, ExperimentBounds
from tendon_mj.lab.recordings import Recording, Uncertain
from tendon_mj.typing import FloatArray
from tests.lab.diagnosis.toy import Added, measured_by
from tests.lab.recorded import recorded

Shapes = Mapping[str, Callable[[FloatArray, FloatArray], FloatArray]]  # (time [s], x [mm]) → N

NOISE = 0.05
DRIVE, TENSION, INPUT = "input_displacement_m", "output_tension_N", "input_tension_N"
PRETENSION = "sheath.pretension"


class ShapedRig(Added):
    """Simulator that adds up the shapes of its parameters."""

    rest = 20.0  # [N]

    def __init__(self, recordings: Sequence[Recording], shapes: Shapes) -> None:
        super().__init__(recordings, dict.fromkeys(shapes, 0.0) | {PRETENSION: 20.0})
        self.shapes = shapes

    def waveform(self, parameter: str, column: str, recording: Recording) -> FloatArray:
        if parameter == PRETENSION or (column == INPUT and parameter != "sheath.a"):
            return np.zeros(recording.time.size)
        place = recording.columns[DRIVE] / 1e-3 * recording.known.get(PRETENSION, 20.0) / 20.0
        return self.shapes[parameter](recording.time, place)


def effect(name: str) -> Effect:
    """An effect of the strength ``sheath.<name>``."""
    return Effect(
        identifier=name,
        name=name,
        equation="",
        signature="",
        source="made",
        binding=on_sheaths(ParameterSpecification(name, "N", -100.0, 100.0, 0.1)),
    )


def record(
    name: str,
    shapes: Shapes,
    truth: Mapping[str, float],
    *,
    uncertain: Mapping[str, Uncertain] | None = None,
    amplitude: float = 0.5e-3,
    like: Recording | None = None,
) -> Recording:
    """Four seconds of the rig under a slow sine, or under what drives another recording."""
    time = np.round(np.arange(0.0, 4.0, 0.01), 6)
    sine = amplitude * np.sin(2.0 * np.pi * 0.5 * time)
    blank = recorded(
        time,
        {DRIVE: ("reel", sine)},
        {TENSION: ("output_tension", NOISE)},
        uncertain=uncertain or {},
    )
    blank = replace(like or blank, name=name)
    random = np.random.default_rng(len(name) + ord(name[0]))
    return measured_by(partial(ShapedRig, shapes=shapes), blank, truth, random)


def diagnosed(
    recordings: Sequence[Recording], held_out: Sequence[Recording], shapes: Shapes, *names: str
) -> Diagnosis:
    """Diagnosis with effects of these names."""
    simulator = partial(ShapedRig, shapes=shapes)
    return diagnose(recordings, held_out, simulator, catalogue=[effect(name) for name in names])


def bounds(high: float = 2e-3, **others: object) -> ExperimentBounds:
    """Bounds of the drive [m], and others."""
    given = {DRIVE: DriveBounds(-high, high, 20e-3, 1.0)}
    return ExperimentBounds(drive=given, **others)  # type: ignore[arg-type]
