"""A policy that drives the rollouts of a sweep: a function of the user that sets the controls."""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import mujoco
import numpy as np

from tendon_mj.errors import InvalidValueError, RecordingError, UnknownNameError
from tendon_mj.lab.recordings import read_text
from tendon_mj.typing import FloatArray

Act = Callable[[mujoco.MjModel, mujoco.MjData], Any]


@dataclass(frozen=True)
class Policy:
    """A function or class of a Python file; the file's text is sent to the workers.

    A function is called as ``name(model, data)`` before every step from the first sample on, and
    sets ``data.ctrl``, where it finds the command of the motion. Time, positions and velocities are
    those of now, readings of sensors those of the step before. Of a class each rollout has its own
    instance, ``name(model)``, that is called so; what it remembers between steps has to be in it.

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
        """The function, or an instance of the class, for one rollout of a model."""
        names = vars(self._module())
        if self.name not in names:
            callables = [n for n, v in names.items() if callable(v) and not n.startswith("_")]
            raise UnknownNameError("function or class", self.name, callables, f"--policy {self}")
        act: Any = names[self.name]
        if isinstance(act, type):
            with self.blamed(f" at {self.name}(model)"):
                act = act(model)
        if not callable(act):
            raise InvalidValueError(
                f"--policy {self}: {self.name} is not a function, or a class whose instances are"
                " called with (model, data)"
            )
        made: Act = act
        return made

    def _module(self) -> ModuleType:
        """The file as a module, run once per process."""
        name = f"{__name__}_{self.digest}"  # where pickle and dataclasses look for it
        if name not in sys.modules:
            module = sys.modules[name] = ModuleType(name)
            module.__file__ = self.path
            try:
                with self.blamed():
                    exec(compile(self.source, self.path, "exec", dont_inherit=True), vars(module))
            except InvalidValueError:
                del sys.modules[name]
                raise
        return sys.modules[name]

    @contextmanager
    def blamed(self, where: str = "") -> Iterator[None]:
        """Name the policy where its code raises; of sys.exit() too, which would end the sweep."""
        try:
            yield
        except (Exception, SystemExit) as error:
            text = f": {error}" if str(error) else ""
            raise InvalidValueError(
                f"--policy {self}: it raised {type(error).__name__}{text}{where}"
            ) from error


def read_policy(text: str) -> Policy:
    """The policy of ``file.py:name``."""
    path, _, name = text.rpartition(":")
    if not path.endswith(".py") or not name.isidentifier():
        raise InvalidValueError(f"--policy {text}: it is not like file.py:name")
    try:
        source = read_text(Path(path))
    except RecordingError as error:
        raise InvalidValueError(f"--policy {text}: {error}") from error
    return Policy(path, name, source)


def try_policy(
    model: mujoco.MjModel, data: mujoco.MjData, policy: Policy, control: FloatArray, lead: int
) -> FloatArray | None:
    """Step once for every row of controls, which a policy may change from row ``lead`` on.

    Returns (steps, nsensordata) readings as of the start of each step; None where MuJoCo warned or
    one is not finite.
    """
    act, readings = policy.make(model), np.empty((len(control), model.nsensordata))
    warmstart = data.qacc_warmstart.copy()
    mujoco.mj_forward(model, data)  # so that it reads the sensors of the start, too
    data.qacc_warmstart[:] = warmstart
    for step, row in enumerate(control):
        data.ctrl[:] = row
        if step >= lead:
            with policy.blamed(f" at time {data.time:.6g} s"):
                act(model, data)
        mujoco.mj_step(model, data)
        readings[step] = data.sensordata
    if any(warning.number for warning in data.warning) or not np.isfinite(readings).all():
        return None
    return readings
