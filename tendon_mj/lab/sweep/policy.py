"""A policy that drives the rollouts of a sweep: a function of the user that sets the controls."""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

import mujoco
import numpy as np

from tendon_mj.errors import InvalidValueError, RecordingError, UnknownNameError
from tendon_mj.lab.recordings import read_text
from tendon_mj.typing import FloatArray

Act = Callable[[mujoco.MjModel, mujoco.MjData], None]

_FORM = "file.py:name"
_RAISED = (Exception, SystemExit)  # sys.exit() of a policy would end the sweep, as if it were done


@dataclass(frozen=True)
class Policy:
    """A function or class of a Python file, whose text goes along to the workers.

    A function is called as ``name(model, data)`` before every step from the first sample on, and
    sets ``data.ctrl``; it finds there what the motion commands. Time, positions and velocities are
    those of now, readings of sensors those of the step before. Of a class each rollout has an
    instance of its own, ``name(model)``, that is called so; what is remembered between steps has to
    be in it.

    Attributes:
        path: of the file.
        name: of the function or class.
        source: text of the file.
    """

    path: str
    name: str
    source: str

    def __str__(self) -> str:
        return f"{self.path}:{self.name}"

    @property
    def digest(self) -> str:
        """16 hexadecimal digits of the file's text."""
        return hashlib.sha256(self.source.encode()).hexdigest()[:16]

    def make(self, model: mujoco.MjModel) -> Act:
        """What acts in one rollout of a model.

        Raises:
            InvalidValueError: the file raises an exception, or the name is none to be called.
            UnknownNameError: the file has no such name.
        """
        found = self._found()
        if not isinstance(found, type):
            return found
        try:
            act = found(model)
        except _RAISED as error:
            raise InvalidValueError(
                f"--policy {self}: {_said(error)} at {self.name}(model)"
            ) from error
        if not callable(act):
            raise InvalidValueError(f"--policy {self}: an instance has no __call__(model, data)")
        made: Act = act
        return made

    def _found(self) -> Act | type[Act]:
        module = self._module()
        if not hasattr(module, self.name):
            names = [n for n, v in vars(module).items() if callable(v) and not n.startswith("_")]
            raise UnknownNameError("function or class", self.name, names, f"--policy {self}")
        found: Act | type[Act] = getattr(module, self.name)
        if not callable(found):
            raise InvalidValueError(f"--policy {self}: {self.name} is no function or class")
        return found

    def _module(self) -> ModuleType:
        """The file as a module, run once in a process."""
        name = f"{__name__}_{self.digest}"  # where pickle and dataclasses look for it
        if name not in sys.modules:
            module = ModuleType(name)
            module.__file__ = self.path
            sys.modules[name] = module
            try:
                exec(compile(self.source, self.path, "exec", dont_inherit=True), vars(module))
            except _RAISED as error:
                del sys.modules[name]
                raise InvalidValueError(f"--policy {self}: {_said(error)}") from error
        return sys.modules[name]


def read_policy(text: str) -> Policy:
    """The policy of ``file.py:name``.

    Raises:
        InvalidValueError: the text is not of that form, or the file cannot be read.
    """
    path, _, name = text.rpartition(":")
    if not path.endswith(".py") or not name.isidentifier():
        raise InvalidValueError(f"--policy {text}: it is not like {_FORM}")
    try:
        source = read_text(Path(path))
    except RecordingError as error:
        raise InvalidValueError(f"--policy {text}: {error}") from error
    return Policy(path, name, source)


def try_policy(
    model: mujoco.MjModel, data: mujoco.MjData, policy: Policy, control: FloatArray, lead: int
) -> FloatArray | None:
    """Step once for every row of controls, which a policy may change from row ``lead`` on.

    Returns:
        (steps, nsensordata) readings as of the start of each step; None where MuJoCo warned or one
        is not finite.

    Raises:
        InvalidValueError: the policy raised an exception.
    """
    act, readings = policy.make(model), np.empty((len(control), model.nsensordata))
    warmstart = data.qacc_warmstart.copy()
    mujoco.mj_forward(model, data)  # so that it reads the sensors of the start, too
    data.qacc_warmstart[:] = warmstart
    for step, row in enumerate(control):
        data.ctrl[:] = row
        if step >= lead:
            _call(act, model, data, policy)
        mujoco.mj_step(model, data)
        readings[step] = data.sensordata
    if any(warning.number for warning in data.warning) or not np.isfinite(readings).all():
        return None
    return readings


def _call(act: Act, model: mujoco.MjModel, data: mujoco.MjData, policy: Policy) -> None:
    try:
        act(model, data)
    except _RAISED as error:
        raise InvalidValueError(
            f"--policy {policy}: {_said(error)} at time {data.time:.6g} s"
        ) from error


def _said(error: BaseException) -> str:
    text = str(error)
    return f"it raised {type(error).__name__}" + (f": {text}" if text else "")
