"""Event and observation terms of mjlab: parameters of sheaths drawn at random, and tensions."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import warp as wp

from tendon_mj.errors import InvalidValueError
from tendon_mj.warp.model import sheaths_of

_OPERATIONS: dict[str, Callable[[Any, float], Any]] = {
    "abs": lambda base, end: base * 0.0 + end,
    "scale": lambda base, end: base * end,
    "add": lambda base, end: base + end,
}
_DISTRIBUTIONS: dict[str, Callable[[Any, Any, Any], Any]] = {
    "uniform": lambda low, high, share: low + share * (high - low),
    "log_uniform": lambda low, high, share: low * (high / low) ** share,
}


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
