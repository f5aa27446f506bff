"""The routes against each other: first motion, outer loop, minor loops and random histories."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from experiments.kaneko1991 import mujoco_route as in_mujoco
from experiments.kaneko1991 import routes
from experiments.kaneko1991.rig import Rig
from experiments.kaneko1991.routes import Array, Trace
from tendon_mj.errors import InvalidValueError
from tendon_mj.progress import Progress, silent

RIG = Rig(friction=0.15, output_stiffness=8e3)  # models/bench: 1/k_se = 1/10 + 1/40 m/MN
STEEP = Rig(friction=1.0 / np.pi)  # λ = 1, output held: nothing but the tendon to refine
STEEP_TRAVEL = 0.3  # of the outer loop of RIG, to reach the same tensions
ELEMENTS = 64
LEG = 2.0  # from one turning point to the next [s]
SAMPLES = 60  # a leg
SLOWNESS = 60.0  # of the elements, see `reference.quasi_static`
TIMESTEP = 1e-4  # of the plugin with a sprung output [s]
LOW, HIGH = -1.2e-3, 2.4e-3  # reaches well beyond the backlash both ways [m]
NAMED = {
    "first motion, pulling": (HIGH,),
    "first motion, loosening": (LOW,),
    "outer loop": (HIGH, LOW, HIGH),
    "minor loops": (HIGH, LOW, 1.2e-3, 0.3e-3, 0.9e-3, -0.4e-3, HIGH),
}
REFINED = (4, 8, 16, 32, 64)
STIFF = 100.0
BATCH = 10  # histories that two threads share at a time


@dataclass(frozen=True, eq=False)
class Agreement:
    """Largest difference of T_out and of T_in between any two routes, over its range.

    Args:
        routes: their names.
        difference: of T_out, per kind of history a symmetric table. Each (routes, routes) [-].
        input_difference: the same of T_in.
        loops: the traces of the minor loops by route, to look at.
        rig: of these histories.
        histories: number of random histories.
    """

    routes: tuple[str, ...]
    difference: dict[str, Array]
    input_difference: dict[str, Array]
    loops: dict[str, Trace]
    rig: Rig
    histories: int

    @property
    def largest(self) -> float:
        """Of T_out, over all histories and pairs [-]."""
        return max(float(table.max()) for table in self.difference.values())

    @property
    def largest_input(self) -> float:
        """Of T_in, over all histories and pairs [-]."""
        return max(float(table.max()) for table in self.input_difference.values())


@dataclass(frozen=True, eq=False)
class Refinement:
    """RMS error of T_out against the closed form over its range, by the number of elements.

    Args:
        elements: n. Shape (k,).
        error: by route [-]. Each (k,).
        order: −slope of the error over n, of the routes whose error falls that long [-].
        rig: of the history, an outer loop.
    """

    elements: Array
    error: dict[str, Array]
    order: dict[str, float]
    rig: Rig


def follow(turns: tuple[float, ...]) -> tuple[Array, Array]:
    """Time [s] and ξ_in [m] from 0 through the turning points, half a cosine a leg."""
    phase = np.arange(len(turns) * SAMPLES + 1) / SAMPLES
    leg = np.minimum(phase.astype(int), len(turns) - 1)
    points = np.array((0.0, *turns))
    share = 0.5 - 0.5 * np.cos(np.pi * (phase - leg))
    return LEG * phase, points[leg] + (points[leg + 1] - points[leg]) * share


def random_turns(count: int, seed: int = 1991) -> list[tuple[float, ...]]:
    """Turning points [m] of histories of four legs.

    The first leg goes most of the way to one end or the other, so that T_out has a range to
    compare with; the other turning points are drawn evenly.
    """
    rng = np.random.default_rng(seed)
    histories = []
    for _ in range(count):
        first = float(rng.choice((LOW, HIGH)) * rng.uniform(0.8, 1.0))
        histories.append((first, *rng.uniform(LOW, HIGH, 3).tolist()))
    return histories


def every_route(rig: Rig, histories: Sequence[tuple[float, ...]]) -> list[dict[str, Trace]]:
    """The five routes of the comparison on histories of ξ_in with equally many legs."""
    time = follow(histories[0])[0]
    travels = np.array([follow(turns)[1] for turns in histories])
    rolled = in_mujoco.plugin(
        rig, time, travels, ELEMENTS, TIMESTEP, threads=min(2, len(histories))
    )
    return [
        {
            "closed form": routes.closed_form(rig, travel, "displacement"),
            "continuum": routes.continuum(rig, travel, "displacement"),
            "elements": routes.slow_elements(
                rig, time, travel, "displacement", ELEMENTS, 2.0 * LEG, SLOWNESS
            ),
            "sheath alone": routes.sheath_alone(rig, travel, "displacement", ELEMENTS),
            "plugin in MuJoCo": Trace(rolled.input_tension[k], rolled.output_tension[k], travel),
        }
        for k, travel in enumerate(travels)
    ]


def _differences(traces: dict[str, Trace]) -> Array:
    """Of T_out and T_in between any two routes, shape (2, routes, routes)."""
    outputs = np.array([trace.output_tension for trace in traces.values()])
    inputs = np.array([trace.input_tension for trace in traces.values()])
    table = np.zeros((2, len(outputs), len(outputs)))
    for end, tensions in enumerate((outputs, inputs)):
        span = np.ptp(tensions[0])
        for i, j in itertools.combinations(range(len(tensions)), 2):
            gap = np.abs(tensions[i] - tensions[j]).max() / span
            table[end, i, j] = table[end, j, i] = gap
    return table


def agree(histories: int = 100, rig: Rig = RIG, progress: Progress = silent) -> Agreement:
    """Compare the routes on the named histories and on so many random ones.

    Raises:
        InvalidValueError: fewer than 0 histories.
    """
    check_histories(histories)
    difference: dict[str, Array] = {}
    loops: dict[str, Trace] = {}
    for name, turns in NAMED.items():
        loops = every_route(rig, [turns])[0]
        difference[name] = _differences(loops)
    label = f"{histories} random histories"
    drawn = random_turns(histories)
    for done in range(0, histories, BATCH):
        batch = drawn[done : done + BATCH]
        tables = [_differences(traces) for traces in every_route(rig, batch)]
        before = difference.get(label, np.zeros_like(tables[0]))
        difference[label] = np.maximum(before, np.max(tables, axis=0))
        progress(label, done + len(batch), histories)
    outputs = {name: tables[0] for name, tables in difference.items()}
    inputs = {name: tables[1] for name, tables in difference.items()}
    return Agreement(tuple(loops), outputs, inputs, loops, rig, histories)


def check_histories(histories: int) -> None:
    """Refuse a number of random histories that cannot be drawn.

    Raises:
        InvalidValueError: fewer than 0.
    """
    if histories < 0:
        raise InvalidValueError(f"histories = {histories} must be ≥ 0")


def refine(rig: Rig = STEEP, progress: Progress = silent) -> Refinement:
    """Run an outer loop with ever more elements, guides or grid intervals."""
    time, travel = follow(NAMED["outer loop"])
    travel = STEEP_TRAVEL * travel
    exact = routes.closed_form(rig, travel, "displacement").output_tension
    stiff, less = rig.stiffened(STIFF), travel / STIFF
    kinds: dict[str, Callable[[int], Trace]] = {
        "continuum": lambda n: routes.continuum(rig, travel, "displacement", n),
        "elements": lambda n: routes.slow_elements(
            rig, time, travel, "displacement", n, 2.0 * LEG, 600.0
        ),
        "sheath alone": lambda n: routes.sheath_alone(rig, travel, "displacement", n),
        "plugin in MuJoCo": lambda n: in_mujoco.plugin(rig, time, travel, n),
        "sheath alone, EA × 100": lambda n: routes.sheath_alone(stiff, less, "displacement", n),
        "plugin in MuJoCo, EA × 100": lambda n: in_mujoco.plugin(stiff, time, less, n),
    }
    error: dict[str, Array] = {}
    for done, (name, run) in enumerate(kinds.items()):
        gaps = [run(n).output_tension - exact for n in REFINED]
        error[name] = np.array([np.sqrt(np.mean(gap**2)) for gap in gaps]) / np.ptp(exact)
        progress("refinement", done + 1, len(kinds))
    counts = np.array(REFINED, float)
    orders = {name: _order(counts, gap) for name, gap in error.items()}
    return Refinement(counts, error, {k: v for k, v in orders.items() if v is not None}, rig)


def _order(counts: Array, error: Array) -> float | None:
    """−slope in the logarithms over at least three points, while each error is a third at most."""
    falling = np.append(error[1:] < error[:-1] / 3.0, False)
    points = int(np.argmin(falling)) + 1
    if points < 3:
        return None
    line = np.polyfit(np.log(counts[:points]), np.log(error[:points]), 1)
    return float(-line[0])
