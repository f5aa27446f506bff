"""`mujoco.sysid` alone: uncertain parameters are fitted in the model, and nothing is named.

`python -m experiments.hidden_effects.rivals.sysid --help`. It knows nothing of sessions: what was
set anew for a training recording has the value that is stated. In a held-out recording it is
fitted, as for every rival.
"""

from __future__ import annotations

import sys
from functools import partial
from typing import Any

from experiments.hidden_effects.case_folder import Case
from experiments.hidden_effects.rivals.rig import run_rival
from experiments.hidden_effects.rivals.term_fit import errors, predict
from tendon_mj.lab.diagnosis import fit_with_sysid
from tendon_mj.lab.replay import Simulator


def solve(case: Case) -> dict[str, Any]:
    """Fit a case; content of result.json."""
    fitted = fit_with_sysid(case.train, case.held_out, simulator=partial(Simulator, threads=1))
    values = {name: value for name, (value, _, _) in fitted.values.items()}
    return {
        "verdict": "prediction only",
        "effects": [],
        "calibrated": fitted.result()["parameters"],
        "gap": errors(case.held_out, predict(case.held_out, values)),
    }


if __name__ == "__main__":
    sys.exit(run_rival(solve, "sysid"))
