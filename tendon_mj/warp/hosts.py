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
_NAMESPACE = types.SimpleNamespace(**vars(mjw) | {each.__name__: each for each in _OURS})
_OPERATIONS: dict[str, Callable[[Any, float], Any]] = {
    "abs": lambda base, end: base * 0.0 + end,
    "scale": lambda base, end: base * end,
    "add": lambda base, end: base + end,
}
_DISTRIBUTIONS: dict[str, Callable[[Any, Any, Any], Any]] = {
    "uniform": lambda low, high, share: low + share * (high - low),
    "log_uniform": lambda low, high, share: low * (high / low) ** share,
}


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
    names = [name for name, value in vars(host).items() if value is mjw or value is _NAMESPACE]
    if not names:
        raise InvalidValueError(
            f"{getattr(host, '__name__', host)!r} has no attribute that is the module mujoco_warp:"
            " give the module or class whose code calls mujoco_warp.put_model"
        )
    for name in names:
        setattr(host, name, _NAMESPACE)

    def undo() -> None:
        for name in names:
            setattr(host, name, mjw)

    return undo


def draw_parameters(
    env: Any,
    env_ids: Any,
    ranges: Mapping[str, tuple[float, float]],
    asset_cfg: Any = None,
    distribution: str = "uniform",
    operation: str = "abs",
    shared_random: bool = False,
) -> None:
    """Draw parameters of sheaths: an event term of mjlab, in the form of its `dr` terms.

    Args:
        env: environment, whose data are ``env.sim.wp_data``.
        env_ids: Torch tensor of the worlds; None: all.
        ranges: ``<sheath>.<parameter>`` → (low, high), as `tendon_mj.ranges` gives them; the sheath
            may go by its tendon, or be a pattern, as in ``*.friction``. A parameter alone is that
            of the tendons of ``asset_cfg``. A pretension acts from the next reset on.
        asset_cfg: ``SceneEntityCfg`` with ``tendon_names``; default: all sheaths of the scene.
        distribution: ``uniform`` or ``log_uniform``, in which low is above 0.
        operation: ``abs``, or ``scale`` or ``add`` to what the model has.
        shared_random: draw one number in each world for all sheaths that a key names.

    Raises:
        UnknownNameError: no such sheath, tendon or parameter.
        UnusedKeyError: a parameter that a sheath has no use for, and why.
        InvalidValueError: an end outside the parameter's range, or low above high; another
            distribution or operation.
    """
    for kind, known in ((distribution, _DISTRIBUTIONS), (operation, _OPERATIONS)):
        if kind not in known:
            raise InvalidValueError(f"draw_parameters: {kind!r} is none of {', '.join(known)}")
    sheaths = sheaths_of(env.sim.wp_data)
    worlds = slice(None) if env_ids is None else env_ids
    for key, ends in ranges.items():
        pattern, _, parameter = key.rpartition(".")
        columns = sheaths.columns([pattern] if pattern else _tendons(asset_cfg))
        for k in columns:
            sheaths.check_use(parameter, sheaths.names[k])
        base = sheaths.of_model[parameter][columns]
        low, high = (_OPERATIONS[operation](base, end) for end in ends)
        sheaths.check(parameter, columns, low, high)
        if distribution == "log_uniform" and not (low > 0.0).all():
            raise InvalidValueError(f"{key}: {distribution} needs a low above 0, not {low.min():g}")
        table = wp.to_torch(sheaths.parameters[parameter])
        part = table[worlds]
        width = 1 if shared_random else len(columns)
        share = part.new_empty((len(part), width)).uniform_()
        low, high = part.new_tensor(low), part.new_tensor(high)
        part[:, columns] = _DISTRIBUTIONS[distribution](low, high, share)
        table[worlds] = part


def tension(env: Any, end: str = "output", asset_cfg: Any = None) -> Any:
    """Tension of sheaths: an observation term of mjlab, (worlds, sheaths) [N].

    Args:
        env: environment, whose data are ``env.sim.wp_data``.
        end: ``input`` or ``output``.
        asset_cfg: ``SceneEntityCfg`` with ``tendon_names``; default: all sheaths of the scene.

    Raises:
        UnknownNameError: a tendon without a sheath.
        InvalidValueError: another end.
    """
    sheaths = sheaths_of(env.sim.wp_data)
    ends = {"input": sheaths.input_tension, "output": sheaths.output_tension}
    if end not in ends:
        raise InvalidValueError(f"tension: end {end!r} is none of {', '.join(ends)}")
    return wp.to_torch(ends[end])[:, sheaths.columns(_tendons(asset_cfg))]


def _tendons(asset_cfg: Any) -> list[str]:
    """Names or patterns of the tendons that a ``SceneEntityCfg`` of mjlab means."""
    if asset_cfg is None:
        return ["*"]
    return [f"{asset_cfg.name}/{name}" for name in asset_cfg.tendon_names or ("*",)]
