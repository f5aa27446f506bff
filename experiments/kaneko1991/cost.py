"""What a simulated second costs by each route, with T_in and T_out within 1 % of range."""

from __future__ import annotations

import functools
import itertools
import math
import time as clock
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import mujoco
import numpy as np

from experiments.kaneko1991 import mujoco_route as in_mujoco
from experiments.kaneko1991 import routes
from experiments.kaneko1991.agreement import LEG, NAMED, RIG, follow
from experiments.kaneko1991.chain import Chain, build_chain
from experiments.kaneko1991.routes import Array
from tendon_mj import reference
from tendon_mj.errors import TendonError
from tendon_mj.progress import Progress, silent
from tendon_mj.replay.rollout import rollout_named_sensors

TARGET = 0.01  # of the range, for either tension
REPEATS = 3
SLOW = ((8, 20.0), (16, 40.0), (32, 40.0), (32, 80.0), (64, 80.0))  # elements, slowness
PLUGIN_STEPS = (1e-3, 5e-4, 2.5e-4, 2e-4, 1e-4)  # for each number of guides [s]
STRIDE = 10e-3  # step of the routes without dynamics, and where all are compared [s]


@dataclass(frozen=True)
class Cost:
    """One route with the fewest elements, then the longest step, that reach ``TARGET``.

    Args:
        route: its name.
        seconds: of wall time per simulated second, the best of some repeats [-].
        step: time step [s].
        elements: n, guides, elements or grid intervals; 0 for the closed form.
        error: largest of T_in or T_out over its range [-].
        inertia: what carries mass in this run.
    """

    route: str
    seconds: float
    step: float
    elements: int
    error: float
    inertia: str


# step, elements, inertia, and the run, which gives T_in and T_out every STRIDE
_Run = Callable[[], tuple[Array, Array]]
_Setting = tuple[float, int, str, _Run]


def _massless(travel: Array) -> dict[str, Iterator[_Setting]]:
    drive: routes.Drive = "displacement"

    def closed() -> Iterator[_Setting]:
        yield STRIDE, 0, "none", _ends(functools.partial(routes.closed_form, RIG, travel, drive))

    def grid() -> Iterator[_Setting]:
        for n in (4, 8, 16, 32, 64, 128):
            yield (
                STRIDE,
                n,
                "none",
                _ends(functools.partial(routes.continuum, RIG, travel, drive, n)),
            )

    def sheath() -> Iterator[_Setting]:
        for n in (4, 8, 16, 32, 64, 128):
            yield (
                STRIDE,
                n,
                "none",
                _ends(functools.partial(routes.sheath_alone, RIG, travel, drive, n)),
            )

    return {"closed form": closed(), "continuum": grid(), "sheath alone": sheath()}


def _ends(run: Callable[[], routes.Trace]) -> _Run:
    def go() -> tuple[Array, Array]:
        trace = run()
        return trace.input_tension, trace.output_tension

    return go


def _with_mass(time: Array, travel: Array) -> dict[str, Iterator[_Setting]]:
    def plugin() -> Iterator[_Setting]:
        for n, step in itertools.product((4, 8, 16, 32, 64, 128), PLUGIN_STEPS):
            model = in_mujoco.plugin_model(RIG, n, step)
            fine = np.arange(0.0, time[-1] + 0.5 * step, step)
            reel, every = np.interp(fine, time, travel), round(STRIDE / step)
            yield step, n, f"{in_mujoco.CARRIAGE:g} kg at the output", _rolled(model, reel, every)

    def elements() -> Iterator[_Setting]:
        for n, slowness in SLOW:
            chain = _slow(n, slowness)
            for parts in (1, 2, 3, 4, 6, 8, 9, 10, 12, 16, 24, 32, 48, 64):
                step = STRIDE / parts
                run = functools.partial(routes.elements, chain, time, travel, "displacement", step)
                yield step, n, f"tendon of {chain.mass.sum():.2g} kg", _ends(run)

    def chained() -> Iterator[_Setting]:
        for (n, slowness), share in itertools.product(SLOW, (1.0, 0.7, 0.5)):
            slow = _slow(n, slowness)
            mass, drag = float(slow.mass.sum()), float(slow.damping.sum())
            held = {"output_stiffness": RIG.output_stiffness, "mass": mass, "damping": drag}
            longest = Chain(elements=n, friction=RIG.friction, **held).longest_timestep
            step = STRIDE / math.ceil(STRIDE / (share * longest))
            chain = Chain(elements=n, friction=RIG.friction, timestep=step, **held)
            model = build_chain(chain, "displacement").compile()
            fine = np.arange(0.0, time[-1] + 0.5 * step, step)
            reel, every = np.interp(fine, time, travel), round(STRIDE / step)
            yield step, n, f"tendon of {mass:.2g} kg", _rolled(model, reel, every)

    return {
        "plugin in MuJoCo": plugin(),
        "elements": elements(),
        "elements in MuJoCo": chained(),
    }


def _slow(n: int, slowness: float) -> reference.ElementChain:
    return reference.quasi_static(routes.elements_chain(RIG, n), 2.0 * LEG, slowness=slowness)


def _rolled(model: mujoco.MjModel, reel: Array, every: int) -> _Run:
    def go() -> tuple[Array, Array]:
        found = rollout_named_sensors(model, reel)
        return found["input_tension"][::every], found["output_tension"][::every]

    return go


def cost(progress: Progress = silent) -> tuple[Cost, ...]:
    """Time every route on an outer loop, in this one process, one thread.

    Raises:
        TendonError: a route does not reach ``TARGET`` with any of its settings.
    """
    coarse, turns = follow(NAMED["outer loop"])
    time = np.arange(round(coarse[-1] / STRIDE) + 1) * STRIDE
    travel = np.interp(time, coarse, turns)
    exact = routes.closed_form(RIG, travel, "displacement")
    ends = (exact.input_tension, exact.output_tension)
    ladders = {**_massless(travel), **_with_mass(time, travel)}
    found = []
    for name, settings in ladders.items():
        found.append(_first_that_will_do(name, settings, ends, float(time[-1])))
        progress("wall time by route", len(found), len(ladders))
    return tuple(found)


def _first_that_will_do(
    name: str, settings: Iterator[_Setting], exact: tuple[Array, Array], duration: float
) -> Cost:
    for step, elements, inertia, run in settings:
        try:
            found = zip(run(), exact, strict=True)
            error = max(float(np.abs(ours - true).max() / np.ptp(true)) for ours, true in found)
        except TendonError:  # this step is too long for MuJoCo
            continue
        if error <= TARGET:
            times = []
            for _ in range(REPEATS):
                start = clock.perf_counter()
                run()
                times.append(clock.perf_counter() - start)
            return Cost(name, min(times) / duration, step, elements, error, inertia)
    raise TendonError(f"no setting of the route {name!r} is within {TARGET:.0%} of the closed form")
