"""Sheaths in packages that put models on MuJoCo Warp by themselves: mjlab, Newton and others."""

from __future__ import annotations

import types
from collections.abc import Callable, Mapping
from typing import Any

import mujoco_warp as mjw
import warp as wp

from tendon_mj.errors import InvalidValueError
from tendon_mj.warp.model import (
    get_data_into,
    make_data,
    put_data,
    put_model,
    reset_data,
    sheaths_of,
)

_OURS = (put_model, make_data, put_data, get_data_into, reset_data)


def take_sheaths(host: Any) -> Callable[[], None]:
    """Let the code of another package put models with sheaths on MuJoCo Warp.

    In the host the name of MuJoCo Warp then stands for a namespace with the functions of this
    package and all else of MuJoCo Warp. Models without sheaths are put as before. Call it before
    the host puts its model.

    Args:
        host: module or class of the other package with an attribute that is the module
            `mujoco_warp`, as `mjlab.sim.sim` has.

    Returns:
        Procedure that gives the host its own functions back.

    Raises:
        InvalidValueError: no attribute of the host is `mujoco_warp`.
    """
    names = [name for name, value in vars(host).items() if value is mjw]
    if not names:
        raise InvalidValueError(
            f"{getattr(host, '__name__', host)!r} has no attribute that is the module mujoco_warp:"
            " give the module or class whose code calls mujoco_warp.put_model"
        )
    ours = {function.__name__: function for function in _OURS}
    namespace = types.SimpleNamespace(**{**vars(mjw), **ours})
    for name in names:
        setattr(host, name, namespace)

    def undo() -> None:
        for name in names:
            setattr(host, name, mjw)

    return undo


def draw_parameters(
    env: Any,
    env_ids: Any,
    ranges: Mapping[str, tuple[float, float]],
    shared_random: bool = False,
) -> None:
    """Draw parameters of sheaths uniformly: an event term of mjlab, in the form of its `dr` terms.

    Args:
        env: environment, whose data are ``env.sim.wp_data``.
        env_ids: Torch tensor of the worlds; None: all.
        ranges: ``<sheath>.<parameter>`` → (low, high), as `tendon_mj.ranges` gives them; the sheath
            may be a pattern, as in ``*.friction``. A pretension acts from the next reset on.
        shared_random: draw one value in each world for all sheaths that a pattern names.

    Raises:
        UnknownNameError: no such sheath or parameter.
        UnusedKeyError: a parameter that a sheath has no use for, and why.
        InvalidValueError: an end outside the parameter's range, or low above high.
    """
    sheaths = sheaths_of(env.sim.wp_data)
    worlds = slice(None) if env_ids is None else env_ids
    for key, (low, high) in ranges.items():
        pattern, _, parameter = key.rpartition(".")
        columns = sheaths.check(pattern, parameter, low, high)
        table = wp.to_torch(sheaths.parameters[parameter])
        part = table[worlds]
        width = 1 if shared_random else len(columns)
        part[:, columns] = part.new_empty((len(part), width)).uniform_(low, high)
        table[worlds] = part
