"""Fit of the tool's numbers to recordings, from several starts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.optimize import least_squares

from experiments.cable_tool.recording import ToolRecording
from experiments.cable_tool.tool import Tool
from tendon_mj.typing import FloatArray

# number → (starts, size of a change that matters)
TORQUE_NUMBERS: dict[str, tuple[tuple[float, ...], float]] = {
    "friction_exponent": ((0.35, 0.45, 0.35), 0.1),
    "wrist_friction": ((0.0, 0.0, 0.0), 0.1),
    "closing_offset": ((0.025, 0.035, 0.03), 0.01),
    "load_difference": ((0.005, 0.0, 0.0), 0.005),
    "opening_offset": ((-0.055, -0.045, -0.06), 0.01),
    "stiffness": ((0.02, 0.01, 0.035), 0.01),
    "take_up": ((0.2, 0.4, 0.3), 0.1),
}
PER_RECORDING: Mapping[str, float | None] = {"opening_offset": None}
_STARTS = 3
_SAMPLES = 700  # of every recording, so that all weigh the same
_LARGE = 4e-3  # beyond this an error counts by its size, not its square [N m]
PLAY_ALONE = 1e6  # a take-up so long that the cable never comes to slide [rad]
_TAKE_UP = (0.01, 0.5)  # half a stroke at most, as mid-stroke is read as sliding [rad]


def fit_tool(
    recordings: Sequence[ToolRecording], held: Mapping[str, float | None] = PER_RECORDING
) -> Tool:
    """Fit the numbers to load and output angle of some recordings.

    The loss is soft-L1: jerks of the brake and one collision in the data would else weigh most.

    Args:
        recordings: to fit to.
        held: numbers that keep a value; one of ``opening_offset`` and ``load_difference`` is None,
            which takes it out of the model.
    """
    names = [name for name in TORQUE_NUMBERS if name not in held]
    base = Tool().replaced(held)
    samples = [_thinned(len(r.time)) for r in recordings]

    def tool_of(values: FloatArray) -> Tool:
        numbers: dict[str, float] = dict(zip(names, values.tolist(), strict=True))
        if "take_up" in numbers:
            numbers["take_up"] = float(np.clip(numbers["take_up"], *_TAKE_UP))
        return base.replaced(numbers)

    def errors(values: FloatArray) -> FloatArray:
        tool = tool_of(values)
        return np.concatenate(
            [(tool.load(r) - r.load)[chosen] for r, chosen in zip(recordings, samples, strict=True)]
        )

    fits = [
        least_squares(
            errors,
            [TORQUE_NUMBERS[name][0][start] for name in names],
            x_scale=[TORQUE_NUMBERS[name][1] for name in names],
            loss="soft_l1",
            f_scale=_LARGE,
            diff_step=1e-4,
            max_nfev=60,
        )
        for start in range(_STARTS)
    ]
    return _fit_angle(tool_of(min(fits, key=lambda fit: float(fit.cost)).x), recordings)


def _fit_angle(tool: Tool, recordings: Sequence[ToolRecording]) -> Tool:
    """The tool with ρ and C by linear least squares; every wrist pose has a zero of its own."""
    rows, angles = [], []
    for pose in sorted({r.pose for r in recordings}):
        mine = [r for r in recordings if r.pose == pose]
        chosen = [_thinned(len(r.time)) for r in mine]
        columns = [
            np.column_stack([-r.input_angle, -tool.carried(r)])[c]
            for r, c in zip(mine, chosen, strict=True)
        ]
        table = np.concatenate(columns)
        angle = np.concatenate([r.output_angle[c] for r, c in zip(mine, chosen, strict=True)])
        rows.append(table - table.mean(axis=0))
        angles.append(angle - angle.mean())
    solution = np.linalg.lstsq(np.concatenate(rows), np.concatenate(angles), rcond=None)[0]
    return tool.replaced({"angle_ratio": float(solution[0]), "compliance": float(solution[1])})


def _thinned(count: int) -> np.ndarray:
    """Indices of at most ``_SAMPLES`` evenly spread samples."""
    return np.unique(np.linspace(0, count - 1, min(count, _SAMPLES)).round().astype(int))
