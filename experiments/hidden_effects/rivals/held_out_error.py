"""Errors on held-out recordings, as entries of result.json."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from experiments.hidden_effects.rivals.rig import Rig, Values, noise
from experiments.hidden_effects.rivals.term_fit import fit_terms
from tendon_mj.lab.recordings import Recording
from tendon_mj.typing import FloatArray


def predict(recordings: Sequence[Recording], parameters: Values) -> FloatArray:
    """(m,) residuals of held-out recordings [noise], with the model's own step.

    What was set anew for each of them is fitted to it, as a diagnosis does.
    """
    rig = Rig(recordings, 1.0)
    shared = {name: value for name, value in parameters.items() if " @ " not in name}
    terms = rig.sessions
    return fit_terms(rig, terms, [term.inert for term in terms], shared).residual


def errors(recordings: Sequence[Recording], residual: FloatArray) -> dict[str, Any]:
    """``gap`` of a result: rms over all signals [noise], and of each in its own unit.

    Args:
        recordings: that were held out.
        residual: (m,) by recording, column and sample [noise].
    """
    squares: dict[str, list[FloatArray]] = {}
    first = 0
    for recording in recordings:
        for column in recording.measured:
            own = residual[first : first + recording.time.size] * noise(recording, column)
            squares.setdefault(column, []).append(own**2)
            first += recording.time.size
    return {
        "held_out": {
            "unit": "noise",
            "after": float(np.sqrt(np.mean(residual**2))),
            "signals": {
                column: {"after": float(np.sqrt(np.mean(np.concatenate(parts))))}
                for column, parts in squares.items()
            },
        }
    }
