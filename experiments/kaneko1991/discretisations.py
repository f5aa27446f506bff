"""Discretisations of each route, from coarse to fine, that its cost is searched over."""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

import mujoco
import numpy as np

from experiments import references
from experiments.kaneko1991 import mujoco_routes, routes
from experiments.kaneko1991.agreement import TENDON
from experiments.kaneko1991.chain import Chain, build_chain
from experiments.kaneko1991.loop import LEG_TIME
from experiments.kaneko1991.routes import Trace
from tendon_mj.lab.replay import rollout_named_sensors
from tendon_mj.typing import FloatArray

SAMPLE_TIME = 10e-3  # step of the routes without dynamics, and where all are compared [s]
COUNTS = (4, 8, 16, 32, 64, 128)  # elements, guides or grid intervals
ELEMENTS_SLOWNESS = ((8, 20.0), (16, 40.0), (32, 40.0), (32, 80.0), (64, 80.0))
STEPS_PER_SAMPLE = (1, 2, 3, 4, 6, 8, 9, 10, 12, 16, 24, 32, 48, 64)  # of the elements
PLUGIN_STEPS = (1e-3, 5e-4, 2.5e-4, 2e-4, 1e-4)  # for each number of guides [s]
CHAIN_STEPS = (1.0, 0.7, 0.5)  # of the elements in MuJoCo, over their longest stable step


class Discretisation(NamedTuple):
    """Discretisation of one route.

    Args:
        step: time step [s].
        elements: n, guides, elements or grid intervals; 0 for the closed form.
        inertia: the parts with mass.
        run: gives T_in and T_out [N] every ``SAMPLE_TIME``.
    """

    step: float
    elements: int
    inertia: str
    run: Callable[[], tuple[FloatArray, FloatArray]]


def discretisations(time: FloatArray, travel: FloatArray) -> dict[str, Iterator[Discretisation]]:
    """Discretisations by route, for ξ_in [m] at every ``SAMPLE_TIME``."""
    return {
        "closed form": _closed_form(travel),
        "continuum": _continuum(travel),
        "sheath alone": _sheath_alone(travel),
        "plugin in MuJoCo": _plugin(time, travel),
        "elements": _elements(time, travel),
        "elements in MuJoCo": _mujoco_elements(time, travel),
    }


def _closed_form(travel: FloatArray) -> Iterator[Discretisation]:
    run = functools.partial(routes.closed_form, TENDON, travel, "displacement")
    yield Discretisation(SAMPLE_TIME, 0, "none", _both_ends(run))


def _continuum(travel: FloatArray) -> Iterator[Discretisation]:
    for n in COUNTS:
        run = functools.partial(routes.continuum, TENDON, travel, "displacement", n)
        yield Discretisation(SAMPLE_TIME, n, "none", _both_ends(run))


def _sheath_alone(travel: FloatArray) -> Iterator[Discretisation]:
    for n in COUNTS:
        run = functools.partial(routes.sheath_alone, TENDON, travel, "displacement", n)
        yield Discretisation(SAMPLE_TIME, n, "none", _both_ends(run))


def _plugin(time: FloatArray, travel: FloatArray) -> Iterator[Discretisation]:
    inertia = f"{mujoco_routes.CARRIAGE:g} kg at the output"
    for n, step in itertools.product(COUNTS, PLUGIN_STEPS):
        model = mujoco_routes.plugin_model(TENDON, n, step)
        yield Discretisation(step, n, inertia, _rollout(model, step, time, travel))


def _elements(time: FloatArray, travel: FloatArray) -> Iterator[Discretisation]:
    for n, slowness in ELEMENTS_SLOWNESS:
        chain = _quasi_static_chain(n, slowness)
        inertia = f"tendon of {chain.mass.sum():.2g} kg"
        for parts in STEPS_PER_SAMPLE:
            step = SAMPLE_TIME / parts
            run = functools.partial(routes.elements, chain, time, travel, "displacement", step)
            yield Discretisation(step, n, inertia, _both_ends(run))


def _mujoco_elements(time: FloatArray, travel: FloatArray) -> Iterator[Discretisation]:
    for (n, slowness), share in itertools.product(ELEMENTS_SLOWNESS, CHAIN_STEPS):
        light = _quasi_static_chain(n, slowness)
        mass = float(light.mass.sum())
        values = {
            "output_stiffness": TENDON.output_stiffness,
            "mass": mass,
            "damping": float(light.damping.sum()),
        }
        longest = Chain(elements=n, friction=TENDON.friction, **values).longest_timestep
        step = SAMPLE_TIME / math.ceil(SAMPLE_TIME / (share * longest))
        chain = Chain(elements=n, friction=TENDON.friction, timestep=step, **values)
        model = build_chain(chain, "displacement").compile()
        yield Discretisation(
            step, n, f"tendon of {mass:.2g} kg", _rollout(model, step, time, travel)
        )


def _quasi_static_chain(n: int, slowness: float) -> references.ElementChain:
    chain = routes.element_chain(TENDON, n)
    return references.quasi_static(chain, 2.0 * LEG_TIME, slowness=slowness)


def _both_ends(run: Callable[[], Trace]) -> Callable[[], tuple[FloatArray, FloatArray]]:
    def tensions() -> tuple[FloatArray, FloatArray]:
        trace = run()
        return trace.input_tension, trace.output_tension

    return tensions


def _rollout(
    model: mujoco.MjModel, step: float, time: FloatArray, travel: FloatArray
) -> Callable[[], tuple[FloatArray, FloatArray]]:
    fine = np.arange(0.0, time[-1] + 0.5 * step, step)
    reel, every = np.interp(fine, time, travel), round(SAMPLE_TIME / step)

    def tensions() -> tuple[FloatArray, FloatArray]:
        result = rollout_named_sensors(model, reel)
        return result["input_tension"][::every], result["output_tension"][::every]

    return tensions
