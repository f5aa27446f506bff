"""Friction for the tendons of an MJCF file: what each bends by, what drives it, what it got."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Literal, NamedTuple

import mujoco

from tendon_mj.attach.elasticity import has_spring
from tendon_mj.attach.friction import add_friction
from tendon_mj.attach.sheathed import actuators_by_tendon, sheaths_by_tendon
from tendon_mj.attach.tendon_choice import choose_tendons
from tendon_mj.attach.tendon_path import end_sites
from tendon_mj.attach.write import write_sheaths
from tendon_mj.builders.load import load_spec, model_path
from tendon_mj.errors import TendonError, TendonWarning
from tendon_mj.verification.stiffness_limit import Pull, pulls, stiffness_limits
from tendon_mj.verification.tendon_bend import bend_at, sampled_poses


class Row(NamedTuple):
    """A tendon after friction was added to a model.

    Attributes:
        tendon: its name.
        bend: total at `qpos0`, with what is not drawn [rad].
        least_bend, most_bend: over poses in the joints' ranges [rad].
        friction: μ.
        axial_stiffness: EA [N]; None without a sheath, or as stiff as the step resolves.
        largest_stiffness: that a step carries [N].
        input: its input end, in words; empty without a sheath.
        drives: what pulls it, in words.
        pull: how stiff that is, and how stiff a step carries.
        done: what was done to it, in words.
        sheath: its name, empty without one.
    """

    tendon: str
    bend: float
    least_bend: float
    most_bend: float
    friction: float
    axial_stiffness: float | None
    largest_stiffness: float
    input: str
    drives: str
    pull: Pull
    done: str
    sheath: str

    @property
    def is_too_stiff(self) -> bool:
        """Whether EA is more than a step carries."""
        return self.axial_stiffness is not None and self.axial_stiffness > self.largest_stiffness

    @property
    def magnified_stiffness(self) -> float:
        """k e^{μφ} that joints meet at most, where it is most bent [N/m]."""
        least = self.least_transmission
        return self.pull.stiffness / least if least > 0.0 else math.inf

    @property
    def is_pulled_too_stiffly(self) -> bool:
        """Whether friction makes more of the stiffness of what pulls than a step carries."""
        pulled = bool(self.sheath) and self.pull.stiffness > 0.0
        return pulled and self.magnified_stiffness > self.pull.largest

    @property
    def transmission(self) -> float:
        """e^{−μφ} at `qpos0`, T_out/T_in as it slides towards the input."""
        return math.exp(-self.friction * self.bend)

    @property
    def least_transmission(self) -> float:
        """e^{−μφ} where it is most bent."""
        return math.exp(-self.friction * self.most_bend)


class Attached(NamedTuple):
    """A written model.

    Attributes:
        path: of the file.
        rows: of the tendons that were asked for.
        said: what `add_friction` and `write_sheaths` warned of.
    """

    path: Path
    rows: tuple[Row, ...]
    said: tuple[str, ...]


def attach_friction(
    model: str,
    tendon: str | Sequence[str],
    path: Path,
    *,
    friction: float,
    axial_stiffness: float | None = None,
    pretension: float | None = None,
    arc_guides: int = 1,
    inner_guides: int | None = None,
    input_end: Literal["first", "last"] = "first",
    extra_bend: float = 0.0,
) -> Attached:
    """Give tendons of a model friction, and write the model as a new file.

    Args:
        model: name of a model of the package, or an MJCF file.
        tendon: as for `add_friction`, as are all the others.
        path: file to write.
        friction: μ.
        axial_stiffness: EA [N].
        pretension: T_0 [N].
        arc_guides: guides on each geom that a tendon may wrap around.
        inner_guides: guides at the input end, for ``extra_bend``.
        input_end: site at which the tendons are pulled, ``first`` or ``last``.
        extra_bend: bend that the drawn path does not show [rad].

    Raises:
        TendonError: what `add_friction` or MuJoCo refuse, or a file that cannot be written as
            asked.
    """
    source = model_path(model)
    spec = load_spec(str(source))
    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            before = spec.compile()
            asked = choose_tendons(spec, tendon)
            unnamed = {one.name for one in asked if not one.element.name}
            had_spring = {one.name for one in asked if has_spring(one.element)}
            sheathed = set(sheaths_by_tendon(spec))
            add_friction(
                spec,
                tendon,
                friction=friction,
                axial_stiffness=axial_stiffness,
                pretension=pretension,
                arc_guides=arc_guides,
                inner_guides=inner_guides,
                input_end=input_end,
                extra_bend=extra_bend,
            )
            write_sheaths(source, spec, path)
    except TendonError:
        raise
    except ValueError as error:  # MuJoCo's
        raise TendonError(f"{source}: {error}") from error
    pulling, sheaths = actuators_by_tendon(spec), sheaths_by_tendon(spec)
    ids = [one.element.id for one in asked]
    bends, limits = _bends(before, ids), stiffness_limits(before, ids)
    rows = []
    for one, (rest, least, most), limit, pull in zip(
        asked, bends, limits, pulls(spec.compile(), ids), strict=True
    ):
        name = one.name
        sheath = sheaths.get(name)
        config = sheath.config if sheath else {}
        more = float(config.get("extra_bend", extra_bend if not sheath else 0.0))
        stiffness = config.get("axial_stiffness")
        moved = config.get("spring") == "cable"
        rows.append(
            Row(
                tendon=name,
                bend=max(rest + more, 0.0),
                least_bend=max(least + more, 0.0),
                most_bend=max(most + more, 0.0),
                friction=float(config.get("friction", friction)),
                axial_stiffness=float(stiffness) if stiffness else None,
                largest_stiffness=limit,
                input=_input(one.element, config) if sheath else "",
                drives=", ".join(one.name or f"actuator {one.id}" for one in pulling.get(name, []))
                or ("its spring" if name in had_spring else "nothing"),
                pull=pull,
                done=_done(sheath, name in sheathed, name in unnamed, moved),
                sheath=sheath.name if sheath else "",
            )
        )
    said = (str(w.message) for w in caught if issubclass(w.category, TendonWarning))
    return Attached(path, tuple(rows), tuple(one.removeprefix("add_friction: ") for one in said))


def _input(tendon: mujoco.MjsTendon, config: Mapping[str, str]) -> str:
    """The input end of a tendon in a sheath: which of its ends, and the name of the site."""
    branches, end = end_sites(tendon), config.get("input_end", "first")
    return f"{end}, {branches[0][0] if end == 'first' else branches[-1][1]}"


def _done(sheath: mujoco.MjsPlugin | None, was_there: bool, unnamed: bool, moved: bool) -> str:
    if sheath is None:
        return "left as it was"
    if was_there:
        return f"left in sheath {sheath.name!r}"
    named = "named, " if unnamed else ""
    return f"{named}sheath {sheath.name!r}{', its spring as elasticity' if moved else ''}"


def _bends(model: mujoco.MjModel, tendons: list[int]) -> list[tuple[float, float, float]]:
    """Bend of each tendon at `qpos0`, and the least and the most over the joints' ranges."""
    data = mujoco.MjData(model)
    bends = [bend_at(model, data, qpos, tendons) for qpos in sampled_poses(model)]
    return [(float(b[0]), float(min(b)), float(max(b))) for b in zip(*bends, strict=True)]
