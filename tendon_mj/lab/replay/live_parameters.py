"""Parameters of sheaths and servos in a simulation, with the bend of each sheath's drawn path.

    φ_x of the law = extra_bend + (drawn_bend − Σ φ_i),   φ_i of the guides at qpos0 [rad]

``drawn_bend`` starts at Σ φ_i, and another value acts as that much more ``extra_bend``: shared
evenly by the guides at sites and at the input end, none of which bends by less than 0. A sheath
without such guides, as where all are on geoms, has no ``drawn_bend``: nothing would take it up.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, MutableMapping
from functools import cached_property
from typing import Any, Final

import mujoco

from tendon_mj.attach import Parameters
from tendon_mj.errors import InvalidValueError
from tendon_mj.lab.recordings import LARGEST
from tendon_mj.plugin import sheath_arrays, sheaths

EXTRA_BEND: Final = "extra_bend"
DRAWN_BEND: Final = "drawn_bend"
CORRECTION: Final = ".drawn_bend.correction"  # custom text of a model: Σ φ_i to drawn_bend [rad]


class LiveParameters(MutableMapping[str, float]):
    """``<sheath>.<parameter>`` and ``<servo>.<gain>`` to value, as `Parameters`, and drawn bends.

    Drawn bends are computed when the first is asked for or set.

    Args:
        model: compiled; its custom texts, as `patch_model` writes them, say which drawn bends
            differ from the path's.
        data: of that model.

    Raises:
        UnknownKeyError: no such parameter.
        InvalidValueError: a value outside its range.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        self._model = model
        self._plugins = Parameters(model, data)
        self._corrections = _stored_corrections(model)
        self._added = {
            sheath: self._plugins[f"{sheath}.{EXTRA_BEND}"] - correction
            for sheath, correction in self._corrections.items()
        }

    def correction(self, sheath: str) -> float:
        """Difference of ``drawn_bend`` from the path's bend [rad]."""
        return self._corrections.get(sheath, 0.0)

    @cached_property
    def _path_bends(self) -> dict[str, float]:
        """Σ φ_i of the sheaths that have a guide which takes up a bend that is not drawn."""
        known = sheaths(self._model)
        if not known:
            return {}
        data = mujoco.MjData(self._model)
        mujoco.mj_forward(self._model, data)
        paths = {name: self._path(data, name) for name in known}
        if any(path.state["arcs"] for path in paths.values()):
            mujoco.mj_step(self._model, data)  # a wrap bends only from the step after it came on
            data.qpos[:] = self._model.qpos0
            mujoco.mj_forward(self._model, data)
            paths = {name: self._path(data, name) for name in known}
        bends = {}
        for name, path in paths.items():
            alone = path.state["arcs"] * path.state["arc_guides"] + path.state["pulleys"]
            if len(path.guides) > alone:
                bends[name] = float(path.guides["angle"].sum())
        return bends

    def _path(self, data: mujoco.MjData, sheath: str) -> Any:
        start = sheaths(self._model)[sheath].state
        return sheath_arrays(self._model, data.plugin_state, sheath, start)

    def _drawn(self, name: str) -> str:
        """The sheath of the name of a drawn bend; empty for any other name."""
        sheath, _, parameter = name.rpartition(".")
        return sheath if parameter == DRAWN_BEND and sheath in self._path_bends else ""

    def __getitem__(self, name: str) -> float:
        sheath, _, parameter = name.rpartition(".")
        if self._drawn(name):
            return self._path_bends[sheath] + self.correction(sheath)
        if parameter == EXTRA_BEND and sheath in self._added:
            return self._added[sheath]
        return self._plugins[name]

    def __setitem__(self, name: str, value: float) -> None:
        sheath, _, parameter = name.rpartition(".")
        extra_bend = f"{sheath}.{EXTRA_BEND}"
        if self._drawn(name):
            if not (math.isfinite(value) and value >= 0.0):
                raise InvalidValueError(f"{name} = {value:g} must be finite and ≥ 0")
            added, correction = self[extra_bend], value - self._path_bends[sheath]
        elif parameter == EXTRA_BEND and sheath in self._corrections:
            added, correction = value, self._corrections[sheath]
        else:
            self._plugins[name] = value
            return
        self._plugins[extra_bend] = added + correction
        self._added[sheath], self._corrections[sheath] = added, correction

    def __delitem__(self, name: str) -> None:
        raise InvalidValueError(f"{name} cannot be removed, only set")

    def __iter__(self) -> Iterator[str]:
        yield from self._plugins
        yield from (f"{sheath}.{DRAWN_BEND}" for sheath in self._path_bends)

    def __len__(self) -> int:
        return len(self._plugins) + len(self._path_bends)


def _stored_corrections(model: mujoco.MjModel) -> dict[str, float]:
    """Sheath → difference of its drawn bend from the path's, of a patched model [rad]."""
    known, corrections = sheaths(model) if model.ntext else {}, {}
    for k in range(model.ntext):
        name = str(mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_TEXT, k))
        if name.endswith(CORRECTION) and name.removesuffix(CORRECTION) in known:
            corrections[name.removesuffix(CORRECTION)] = custom_numbers(model, k, 1)[0]
    return corrections


def custom_numbers(model: mujoco.MjModel, text: int, count: int) -> list[float]:
    """The ``count`` numbers in a custom text of a model.

    Raises:
        InvalidValueError: it holds something else, or a number that is not finite or too large.
    """
    start, size = model.text_adr[text], model.text_size[text]
    content = bytes(model.text_data[start : start + size]).rstrip(b"\0").decode(errors="replace")
    try:
        numbers = [float(word) for word in content.split()]
    except ValueError:
        numbers = []
    if len(numbers) != count or not all(abs(number) <= LARGEST for number in numbers):
        name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_TEXT, text)
        raise InvalidValueError(
            f"custom text {name!r} of the model is {content[:60]!r}; a name that ends so holds"
            f" {count} finite number{'s' if count > 1 else ''}; mend it, or take it out"
        )
    return numbers
