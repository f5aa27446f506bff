"""`python -m experiments.step_convergence MODEL.xml…`: sheaths at the model's own step, and finer.

Every tendon that an actuator pulls gets friction, at one axial stiffness after the other. The model
runs at its own step h and at h/16 with the same controls, smooth and random, held for a step of h.
Joints whose angles differ between the two in MuJoCo alone are left out: with friction they cannot
do better.
"""

from __future__ import annotations

import sys
import warnings
from pathlib import Path
from typing import Annotated, NamedTuple

import mujoco
import numpy as np
import tyro
from numpy.typing import NDArray
from rich.table import Table

from experiments.command import run_experiment
from tendon_mj import TendonWarning, add_friction, largest_stiffness, load_spec, view_sheath
from tendon_mj.cli import Output, console, progress_bar
from tendon_mj.errors import InvalidValueError
from tendon_mj.lab.progress import Progress
from tendon_mj.lab.step_cost import smooth_controls
from tendon_mj.typing import FloatArray

_REFINEMENT = 16
_MOVES = 0.01  # travel over which a joint counts as moving, over that of the joint that moves most
_PULLS = 0.01  # tension beyond which a tendon counts as pulled, over that of the strongest
_CONVERGED = 0.01  # rms by which stock MuJoCo's angle may differ between the steps, over its travel
_COLUMNS = {  # of the table, by quantity
    "angle": "angle",
    "output_tension": "T_out",
    "friction_work": "friction work",
    "total_friction_work": "in all",
}


class Run(NamedTuple):
    """Motion, tensions and friction work at the ends of the coarse steps.

    Attributes:
        qpos: (n, nq) [rad or m].
        output_tension: (n, sheaths) [N].
        friction_work: (sheaths,) of each sheath by the end [J].
        unstable: whether MuJoCo warned, or something is not finite.
    """

    qpos: FloatArray
    output_tension: FloatArray
    friction_work: FloatArray
    unstable: bool


def controls(model: mujoco.MjModel, steps: int, amplitude: float, seed: int) -> FloatArray:
    """(steps, nu) smooth controls around the middle of their ranges, growing from rest."""
    time = model.opt.timestep * np.arange(steps)
    grown = np.minimum(1.0, time / 0.3)[:, None]
    return np.asarray(grown * smooth_controls(model, steps, seed, amplitude))


def simulate(
    model: mujoco.MjModel, sheathed: list[str], inputs: FloatArray, refinement: int
) -> Run:
    """Run a model with each control held for ``refinement`` steps."""
    data = mujoco.MjData(model)
    model.opt.timestep /= refinement
    views = [view_sheath(model, data, tendon) for tendon in sheathed]
    qpos = np.empty((len(inputs), model.nq))
    tension = np.empty((len(inputs), len(views)))
    for k, control in enumerate(inputs):
        data.ctrl[:] = control
        mujoco.mj_step(model, data, refinement)
        qpos[k] = data.qpos
        tension[k] = [float(view.output_tension) for view in views]
    model.opt.timestep *= refinement
    work = np.array([view.friction_work.sum() for view in views])
    unstable = bool(data.warning.number.any()) or not np.isfinite(qpos).all()
    return Run(qpos, tension, work, unstable)


def rms(x: FloatArray) -> FloatArray:
    """Root mean square of each column."""
    return np.asarray(np.sqrt(np.mean(x * x, axis=0)))


def differences(
    coarse: Run, fine: Run, joints: NDArray[np.intp], travel: FloatArray
) -> dict[str, list[float]]:
    """Deviation of the coarse run from the fine one, over the fine one's range.

    Angles are over what the joint travels without friction, as one that friction holds travels next
    to nothing; ``angle_over_own_travel`` is over that.

    Args:
        coarse, fine: runs of one model.
        joints: columns of qpos.
        travel: (nq,) of the model without friction [rad or m].
    """
    angle = rms(coarse.qpos - fine.qpos)[joints]
    pulled = rms(fine.output_tension) > _PULLS * max(rms(fine.output_tension), default=0.0)
    rubs = fine.friction_work > _PULLS * max(fine.friction_work, default=0.0)
    tension = rms(coarse.output_tension - fine.output_tension)[pulled]
    return {
        "angle": list(angle / travel[joints]),
        "angle_over_own_travel": list(angle / np.ptp(fine.qpos, axis=0)[joints]),
        "output_tension": list(tension / rms(fine.output_tension)[pulled]),
        "friction_work": list(
            np.abs(coarse.friction_work - fine.friction_work)[rubs] / fine.friction_work[rubs]
        ),
        "total_friction_work": [
            float(abs(coarse.friction_work.sum() / fine.friction_work.sum() - 1.0))
        ]
        if rubs.any()
        else [],
    }


def _sheathed(
    path: Path, tendons: list[str], friction: float, stiffness: float | None
) -> mujoco.MjModel:
    spec = load_spec(str(path))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", TendonWarning)  # of those on which nothing rubs
        add_friction(spec, tendons, friction=friction, axial_stiffness=stiffness, sensors=())
    return spec.compile()


def _driven(model: mujoco.MjModel) -> list[str]:
    """Names of the tendons that actuators pull."""
    on_tendon = model.actuator_trntype == mujoco.mjtTrn.mjTRN_TENDON.value
    return [model.tendon(k).name for k in sorted(set(model.actuator_trnid[on_tendon, 0]))]


def step_convergence(
    models: Annotated[tuple[Path, ...], tyro.conf.Positional],
    out: Path = Path("out/step_convergence"),
    friction: float = 0.1,
    stiffness: tuple[float, ...] = (1e3, 1e4, 1e5, 1e6, 1e7),
    duration: float = 1.0,
    amplitude: float = 0.3,
    seed: int = 0,
) -> None:
    """Difference between a model's own step and one 16 times shorter, at several stiffnesses.

    Args:
        models: MJCF files with actuators on tendons.
        out: folder for result.json.
        friction: mu of every sheath.
        stiffness: axial stiffnesses EA in N, after the one that is chosen if none is given.
        duration: simulated time in s.
        amplitude: of the controls, over half their range.
        seed: of the controls.
    """
    output = Output(out)
    result: dict[str, object] = {}
    with progress_bar() as progress:
        for path in models:
            result[path.stem] = _converge(
                path, friction, stiffness, duration, amplitude, seed, progress
            )
    output.result(result)
    output.close()


def _converge(
    path: Path,
    friction: float,
    stiffnesses: tuple[float, ...],
    duration: float,
    amplitude: float,
    seed: int,
    progress: Progress,
) -> dict[str, object]:
    """Differences of one model."""
    stock = load_spec(str(path)).compile()
    driven = _driven(stock)
    if not driven:
        raise InvalidValueError(f"{path}: no actuator pulls a tendon")
    inputs = controls(stock, round(duration / stock.opt.timestep), amplitude, seed)
    coarse, fine = (simulate(stock, [], inputs, r) for r in (1, _REFINEMENT))
    travel = np.ptp(fine.qpos, axis=0)
    converged = rms(coarse.qpos - fine.qpos) <= _CONVERGED * travel
    joints = np.flatnonzero(converged & (travel > _MOVES * travel.max()))
    carried = [largest_stiffness(stock, name) for name in driven]
    table = Table("EA [N]", *_COLUMNS.values(), "", title=path.stem)
    rows: list[dict[str, object]] = []
    for number, stiffness in enumerate((None, *stiffnesses)):
        model = _sheathed(path, driven, friction, stiffness)
        coarse, fine = (simulate(model, driven, inputs, r) for r in (1, _REFINEMENT))
        differs = differences(coarse, fine, joints, travel)
        unstable = coarse.unstable or fine.unstable
        rows.append({"axial_stiffness": stiffness, "unstable": unstable, **differs})
        shown = (differs[column] for column in _COLUMNS)
        cells = (f"{np.median(d):.1%} ({max(d):.1%})" if d else "-" for d in shown)
        label = "chosen" if stiffness is None else f"{stiffness:g}"
        table.add_row(label, *cells, "unstable" if unstable else "")
        progress(path.stem, number + 1, 1 + len(stiffnesses))
    console.print(table)
    console.print(
        f"median (largest); {len(joints)} of {stock.nq} coordinates move and converge in MuJoCo "
        f"alone; the step carries {min(carried):.2g} to {max(carried):.2g} N"
    )
    return {
        "coordinates": [int(j) for j in joints],
        "largest_stiffness": dict(zip(driven, carried, strict=True)),
        "rows": rows,
    }


if __name__ == "__main__":
    sys.exit(run_experiment(step_convergence, "step_convergence"))
