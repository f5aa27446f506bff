"""`python -m experiments.warp_comparison [MODEL…]`: sheaths on MuJoCo Warp beside the plugin's.

`bench`, `finger` and models in files run on both engines with the same smooth random controls. To a
model in a file friction is added on every tendon that an actuator pulls, at one axial stiffness
after the other. What the engines themselves differ by is measured on the same model without
sheaths: on bench and finger tendons are MuJoCo's springs then, of the same stiffness, and a model
without controls is pushed at its joints.
"""

from __future__ import annotations

import sys
import time
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import mujoco
import numpy as np
import tyro
from rich.table import Table

from experiments.command import run_experiment
from tendon_mj import TendonWarning, add_friction, load_spec, remove_friction
from tendon_mj.cli import Output, console, progress_bar
from tendon_mj.errors import MissingPackageError
from tendon_mj.lab.step_cost import smooth_controls
from tendon_mj.plugin import segment_tensions, unsolved_evaluations
from tendon_mj.typing import FloatArray

try:
    import mujoco_warp as mjw
    import warp as wp

    from tendon_mj import warp as sheathed_warp
except ImportError as error:
    raise MissingPackageError(f"{error}: pip install 'tendon-mj[warp]'") from None


_AMPLITUDES = {
    "bench": 5e-4,
    "finger": 1.0,
}  # of the reel [m]; of the controls over half their range
_PUSH = 20.0  # force on the joints of a model without controls [N]


class Pair(NamedTuple):
    """A model with sheaths and the same without.

    Attributes:
        name: of the row.
        model: with sheaths.
        stock: without.
        amplitude: of the controls, over half their range.
    """

    name: str
    model: mujoco.MjModel
    stock: mujoco.MjModel
    amplitude: float


def warp_comparison(
    models: Annotated[tuple[str, ...], tyro.conf.Positional] = ("bench", "finger"),
    out: Path = Path("out/warp_comparison"),
    friction: float = 0.15,
    stiffness: tuple[float, ...] = (1e5,),
    duration: float = 2.0,
    worlds: int = 64,
    rounds: int = 5,
    seed: int = 0,
) -> None:
    """Compare sheaths on MuJoCo Warp with the plugin's, in single precision.

    Args:
        models: bench, finger, or MJCF files.
        out: folder for result.json.
        friction: mu of every sheath of a given model.
        stiffness: axial stiffnesses EA in N of these, after the one that is chosen without any.
        duration: simulated time in s.
        worlds: among which steps are timed.
        rounds: of 20 steps, of which the median time counts.
        seed: of the controls.
    """
    wp.config.quiet = True
    output = Output(out)
    pairs = pairs_of(models, friction, (None, *stiffness))
    rows: list[dict[str, Any]] = []
    with progress_bar() as progress:
        for number, pair in enumerate(pairs):
            rows.append(_compare(pair, duration, worlds, rounds, seed))
            progress("models", number + 1, len(pairs))
    table = Table("model", "tensions", "99.9 %", "rms", "joints", "joints, stock", "step", "stock")
    for row in rows:
        relative = (f"{row[key]:.1e}" for key in ("largest", "most", "rms", "joints", "stock"))
        times = (f"{1e6 * row[key]:.3g} µs" for key in ("step", "stock_step"))
        table.add_row(str(row["model"]), *relative, *times)
    console.print(table)
    console.print(
        "tensions: largest difference over their range; joints: largest difference in rad or m; "
        f"step: of one of {worlds} worlds on {wp.get_device()}"
    )
    output.result({"rows": rows, "device": str(wp.get_device()), "worlds": worlds})
    output.close()


def pairs_of(
    models: Sequence[str], friction: float, stiffnesses: Sequence[float | None]
) -> list[Pair]:
    """`bench` and `finger` as they are, and given models with sheaths of each stiffness [N]."""
    pairs: list[Pair] = []
    for model in models:
        if model in _AMPLITUDES:
            pairs.append(_own(model, _AMPLITUDES[model]))
        else:
            pairs += [_given(Path(model), friction, ea) for ea in stiffnesses]
    return pairs


def _own(name: str, amplitude: float) -> Pair:
    """A model of ours, and the same with MuJoCo's springs in the place of its sheaths."""
    model, spec = load_spec(name).compile(), load_spec(name)
    configs = [p.config for p in spec.plugins if "axial_stiffness" in p.config]
    laws = [(c["tendon"], float(c["axial_stiffness"]), float(c["pretension"])) for c in configs]
    remove_friction(spec, "*")
    for tendon, ea, pretension in laws:
        rest = float(model.tendon_length0[model.tendon(tendon).id]) / (1.0 + pretension / ea)
        spec.tendon(tendon).stiffness[0] = ea / rest
        spec.tendon(tendon).springlength = [0.0, rest]
    return Pair(name, model, spec.compile(), amplitude)


def _given(path: Path, friction: float, stiffness: float | None) -> Pair:
    """A given model with friction on every tendon that an actuator pulls, and without."""
    spec = load_spec(str(path))
    stock = spec.compile()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", TendonWarning)
        add_friction(spec, "*", friction=friction, axial_stiffness=stiffness)
    label = "chosen" if stiffness is None else f"{stiffness:g} N"
    return Pair(f"{path.stem}, EA {label}", spec.compile(), stock, 1.0)


def _compare(pair: Pair, duration: float, worlds: int, rounds: int, seed: int) -> dict[str, Any]:
    """Row of the table for a pair of models."""
    steps = round(duration / pair.model.opt.timestep)
    tension, differs, joints, unsolved = _sheaths_apart(pair, steps, seed)
    span = float(np.ptp(tension))
    return {
        "model": pair.name,
        "range": [float(tension.min()), float(tension.max())],
        "largest": float(differs.max()) / span,
        "most": float(np.quantile(differs, 0.999)) / span,
        "rms": float(np.sqrt(np.mean(differs**2))) / span,
        "joints": joints,
        "stock": _stock_apart(pair, steps, seed),
        "unsolved": unsolved,
        "step": _step_time(pair.model, pair.amplitude, worlds, rounds, seed),
        "stock_step": _step_time(pair.stock, pair.amplitude, worlds, rounds, seed),
    }


def _controls(model: mujoco.MjModel, steps: int, amplitude: float, seed: int) -> FloatArray:
    """(steps, nu) smooth controls in single precision, as Warp has them."""
    return smooth_controls(model, steps, seed, amplitude).astype(np.float32).astype(float)


def _sheaths_apart(pair: Pair, steps: int, seed: int) -> tuple[FloatArray, FloatArray, float, int]:
    """The plugin's tensions [N], Warp's deviation, the same of joints, steps not solved."""
    model, data = pair.model, mujoco.MjData(pair.model)
    m, d = sheathed_warp.put_model(model), sheathed_warp.make_data(model)
    sheaths = sheathed_warp.sheaths_of(d)
    tension, differs, joints = [], [], 0.0
    for control in _controls(model, steps, pair.amplitude, seed):
        data.ctrl[:] = control
        mujoco.mj_step(model, data)
        _step(m, d, control)
        tension.append(np.concatenate([segment_tensions(model, data, k)[1] for k in sheaths.names]))
        differs.append(np.abs(sheaths.tension.numpy()[0] - tension[-1]))
        joints = max(joints, float(np.abs(d.qpos.numpy()[0] - data.qpos).max()))
    unsolved = sum(unsolved_evaluations(model, data).values()) + int(sheaths.unsolved.numpy().sum())
    return np.array(tension), np.array(differs), joints, unsolved


def _stock_apart(pair: Pair, steps: int, seed: int) -> float:
    """Largest difference of a coordinate between the engines without sheaths."""
    model, data = pair.stock, mujoco.MjData(pair.stock)
    m, d = mjw.put_model(model), mjw.make_data(model)
    largest, time_ = 0.0, model.opt.timestep * np.arange(steps)
    inputs = _controls(model, steps, pair.amplitude, seed)
    for control, now in zip(inputs, time_, strict=True):
        if model.nu == 0:
            data.qfrc_applied[:] = np.float32(_PUSH * np.sin(2.0 * np.pi * now))
            d.qfrc_applied.assign(data.qfrc_applied[None].astype(np.float32))
        data.ctrl[:] = control
        mujoco.mj_step(model, data)
        _step(m, d, control)
        largest = max(largest, float(np.abs(d.qpos.numpy()[0] - data.qpos).max()))
    return largest


def _step(m: Any, d: Any, control: FloatArray) -> None:
    """One step of all worlds under the same control."""
    if control.size:
        d.ctrl.assign(np.broadcast_to(control, d.ctrl.shape).astype(np.float32))
    mjw.step(m, d)


def _step_time(
    model: mujoco.MjModel, amplitude: float, worlds: int, rounds: int, seed: int, steps: int = 20
) -> float:
    """Time of a step of one among many worlds [s], the median of some rounds.

    Each world has controls of its own, new ones in each round. On a GPU a round is a captured graph
    and the clock counts, on the CPU device the processor's time.
    """
    m, d = sheathed_warp.put_model(model), sheathed_warp.make_data(model, worlds)
    on_gpu = wp.get_device().is_cuda
    clock = time.perf_counter if on_gpu else time.process_time
    mjw.step(m, d)  # compiles
    graph = None
    if on_gpu:
        with wp.ScopedCapture() as capture:
            for _ in range(steps):
                mjw.step(m, d)
        graph = capture.graph
    rng, times = np.random.default_rng(seed), []
    inputs = _controls(model, rounds * worlds, amplitude, seed)
    for _ in range(rounds):
        if model.nu:
            d.ctrl.assign(rng.permutation(inputs)[:worlds].astype(np.float32))
        wp.synchronize()
        begin = clock()
        if graph is None:
            for _ in range(steps):
                mjw.step(m, d)
        else:
            wp.capture_launch(graph)
        wp.synchronize()
        times.append(clock() - begin)
    return float(np.median(times)) / (steps * worlds)


if __name__ == "__main__":
    sys.exit(run_experiment(warp_comparison, "warp_comparison"))
