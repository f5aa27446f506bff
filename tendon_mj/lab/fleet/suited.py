"""Which recordings of a rig can be fitted together, and why the others cannot."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime

import mujoco

from tendon_mj.errors import TendonError
from tendon_mj.lab.diagnosis import Problem, all_samples, check_recordings, check_simulation
from tendon_mj.lab.recordings import Recording
from tendon_mj.lab.replay import Simulator, suppress_unsolved_warnings


@suppress_unsolved_warnings()
def suited(
    recordings: Mapping[datetime, Recording], model: mujoco.MjModel
) -> tuple[dict[datetime, Recording], dict[datetime, str]]:
    """The recordings of a rig that a calibration takes, and why it refuses the others.

    Args:
        recordings: date → recording, in the order of time.
        model: of the rig.
    """
    kept, refused = dict[datetime, Recording](), dict[datetime, str]()
    try:
        check_recordings(list(recordings.values()), ())
        _check_simulation(*recordings.values(), model=model)
    except TendonError:
        for date, recording in recordings.items():
            try:
                check_recordings([*kept.values(), recording], ())
                _check_simulation(recording, model=model)
                kept[date] = recording
            except TendonError as error:
                refused[date] = str(error)
        return kept, refused
    return dict(recordings), refused


def _check_simulation(*recordings: Recording, model: mujoco.MjModel) -> None:
    simulate = Simulator(recordings, model=model, threads=1)
    check_simulation(Problem(recordings, simulate, all_samples(recordings)))
