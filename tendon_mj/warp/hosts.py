"""Other packages that put models with sheaths on MuJoCo Warp by themselves: mjlab, Newton, …"""

from __future__ import annotations

import types
from collections.abc import Callable
from typing import Any

import mujoco_warp as mjw

from tendon_mj.errors import InvalidValueError
from tendon_mj.warp.model import get_data_into, make_data, put_data, put_model, reset_data

_OURS = (put_model, make_data, put_data, get_data_into, reset_data)
_NAMESPACE = types.SimpleNamespace(**vars(mjw) | {each.__name__: each for each in _OURS})


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
