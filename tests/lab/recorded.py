"""Recordings in a few words."""

import numpy as np

from tendon_mj.lab.recordings import Measured, Recording


def recorded(time, drive, measured, of="bench", /, **more):
    """A recording of a model.

    Args:
        time: [s].
        drive: column to its actuator and series.
        measured: column to its sensor, or to that and noise, and a series; without one it is 0.
        of: name or path of its model.
        more: other fields of a `Recording`.
    """
    sensors = {c: (m, None) if isinstance(m, str) else m for c, m in measured.items()}
    columns = {column: series for column, (_, series) in drive.items()}
    columns |= {c: rest[0] if rest else np.zeros(len(time)) for c, (_, _, *rest) in sensors.items()}
    return Recording(
        **{
            "name": "made up",
            "model": str(of),
            "source": "made up",
            "time": time,
            "columns": columns,
            "drive": {column: actuator for column, (actuator, _) in drive.items()},
            "measured": {c: Measured(sensor, noise) for c, (sensor, noise, *_) in sensors.items()},
        }
        | more
    )


def written(folder, rows, columns="time_s,input_displacement_m,input_tension_N"):
    """Path of a table and its description: the reel of the bench drives, its tension is read."""
    _, drive, measured = columns.split(",")
    (folder / "r.csv").write_text(f"{columns}\n{rows}")
    (folder / "r.toml").write_text(
        f'model = "bench"\nsource = "a test"\n[drive]\n{drive} = "reel"\n'
        f'[measured]\n{measured} = {{ sensor = "input_tension" }}\n'
    )
    return str(folder / "r.csv")
