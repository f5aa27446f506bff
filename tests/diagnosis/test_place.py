"""Where effects may sit on a model."""

from __future__ import annotations

from tendon_mj.diagnosis.catalogue import candidates
from tendon_mj.diagnosis.effect import Rig


def on(*sheaths: str, known: frozenset[str] = frozenset()) -> list[str]:
    """Elements of every candidate for dry friction that the tension does not change."""
    rig = Rig(
        values={f"{sheath}.constant_friction": 0.0 for sheath in sheaths},
        known=known,
        uncertain=frozenset(),
        spans={},
        inputs=(),
        free_joints=(),
    )
    return [c.where for c in candidates(rig, frozenset()) if c.identifier == "constant_friction"]


def test_an_effect_of_the_sheath_is_on_all_of_them_or_on_one() -> None:
    assert on("left") == ["left"]
    assert on("left", "right") == ["left, right", "left", "right"]


def test_what_is_known_of_one_sheath_leaves_the_others() -> None:
    known = frozenset({"left.constant_friction"})
    assert on("left", "right", known=known) == ["right"]
