"""Sensors of sheaths: their numbers in `sensordata`, and the quantities that they show."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import mujoco
import numpy as np
import warp as wp

from tendon_mj.errors import NoPluginsError
from tendon_mj.plugin import attribute_of, sensor_kind, sheaths
from tendon_mj.warp import reactions
from tendon_mj.warp.cells import cells_of
from tendon_mj.warp.support import Rows, Simulated, rows_of


def sensors_of_sheaths(model: mujoco.MjModel) -> dict[int, str]:
    """Sensors that show something of a sheath, with the kind; empty for both ends' tensions."""
    own = {instance.state for instance in sheaths(model).values()}
    sensors = {}
    for sensor in np.flatnonzero(model.sensor_plugin >= 0).tolist():
        kind = sensor_kind(model, sensor)
        if kind or int(model.plugin_stateadr[model.sensor_plugin[sensor]]) in own:
            sensors[sensor] = kind
    return sensors


def force_sensors(model: mujoco.MjModel) -> Any:
    """Warp array of the sensors of force and torque."""
    sensors = np.flatnonzero(np.isin(model.sensor_type, (reactions.FORCE, reactions.TORQUE)))
    return wp.array(sensors.astype(np.int32), dtype=wp.int32)


def shown_numbers(model: mujoco.MjModel, simulated: Mapping[str, Simulated]) -> Any:
    """(numbers, 3) Warp array of every number that sensors of sheaths show.

    Its columns are the quantity, its row in the arrays of `Tendons`, and its address in
    `sensordata`.

    Args:
        model: with sheaths.
        simulated: each by name.
    """
    rows: list[tuple[int, int, int]] = []
    at, slips = rows_of(simulated), _slips(model, simulated)
    for sensor, kind in sensors_of_sheaths(model).items():
        k = _shown(model, sensor, simulated)
        shown = _quantities(kind, k, at, slips[k])
        start, width = int(model.sensor_adr[sensor]), int(model.sensor_dim[sensor])
        rows += [(*one, start + at) for at, one in enumerate(shown) if at < width]
    return wp.array(np.array(rows, np.int32).reshape(-1, 3), dtype=wp.int32)


def _slips(
    model: mujoco.MjModel, simulated: Mapping[str, Simulated]
) -> list[list[tuple[int, int]]]:
    """Quantity and row of the slip of each guide, for each sheath; a pulley has none."""
    slips, first_cell = [], 0
    for guide, sheath in zip(rows_of(simulated).guide, simulated.values(), strict=True):
        if not sheath.state["inextensible"]:
            slips.append([(reactions.SLIP, guide + i) for i in range(len(sheath.guides))])
            continue
        cells, owners = cells_of(model, sheath)
        own = zip(owners[1:], sheath.guides["is_pulley"], strict=True)
        slips.append(
            [(reactions.SLIDE, -1 if pulley else first_cell + cell) for cell, pulley in own]
        )
        first_cell += len(cells)
    return slips


def _quantities(
    kind: str, k: int, at: Rows, slips: list[tuple[int, int]]
) -> Iterator[tuple[int, int]]:
    """Quantity and row of each number of a sensor."""
    segment, guide, n = at.shown[k], at.guide[k], len(slips)
    if kind in ("", "input_tension"):
        yield reactions.TENSION, segment
    if kind in ("", "output_tension"):
        yield reactions.TENSION, segment + n
    if kind == "tension":
        yield from ((reactions.TENSION, segment + j) for j in range(n + 1))
    if kind == "bend_angle":
        yield from ((reactions.ANGLE, guide + i) for i in range(n))
    if kind == "slip":
        yield from slips
    if kind in ("reel_displacement", "unsolved"):
        yield (reactions.WOUND if kind == "reel_displacement" else reactions.UNSOLVED), k


def _shown(model: mujoco.MjModel, sensor: int, simulated: Mapping[str, Simulated]) -> int:
    """Index of the sheath that a sensor shows.

    Raises:
        NoPluginsError: its configuration names no tendon as the model has it.
    """
    instance = int(model.sensor_plugin[sensor])
    for k, own in enumerate(sheaths(model).values()):
        if own.state == int(model.plugin_stateadr[instance]):
            return k
    tendons = [int(sheath.state["tendon"]) for sheath in simulated.values()]
    if model.sensor_objtype[sensor] == mujoco.mjtObj.mjOBJ_TENDON:
        return tendons.index(int(model.sensor_objid[sensor]))
    written = attribute_of(model._address, instance, "tendon")
    names = [model.tendon(tendon).name for tendon in tendons]
    meant = [k for k, name in enumerate(names) if name == written] or [
        k for k, name in enumerate(names) if written in name
    ]
    if len(meant) != 1:
        raise NoPluginsError(
            f"sensor {model.sensor(sensor).name!r} shows a sheath of tendon {written!r}, which "
            'tendon_mj.warp does not find: give it objtype="tendon" and the tendon as its objname'
        )
    return meant[0]
