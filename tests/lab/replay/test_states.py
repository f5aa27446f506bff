"""Values for one recording alone, names for several parameters, and how a drive is held."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tendon_mj import (
    Session,
    Simulator,
    Uncertain,
    read_recording,
    replay_recording,
    write_recording,
)
from tendon_mj.errors import RecordingError, UnknownNameError
from tendon_mj.lab.parameter_names import expand, matching
from tests.lab.replay.rigs import TENSION, bench
from tests.refusals import refusing


def test_a_value_for_one_recording_is_what_it_would_be_alone() -> None:
    two = [bench("one"), bench("two.b @ c")]
    plain, changed = Simulator(two)([{}, {"sheath.pretension @ two.b @ c": 12.0}])
    alone = Simulator(two[1:])([{"sheath.pretension": 12.0}])[0][0]
    np.testing.assert_array_equal(changed[0][TENSION], plain[0][TENSION])
    np.testing.assert_array_equal(changed[1][TENSION], alone[TENSION])
    assert not np.array_equal(changed[1][TENSION], plain[1][TENSION])


def test_a_value_for_one_recording_goes_before_one_for_all() -> None:
    two = [bench("one"), bench("two")]
    both = {"sheath.pretension": 15.0, "sheath.pretension @ two": 12.0}
    answers = Simulator(two)([both])[0]
    for row, pretension in zip(answers, (15.0, 12.0), strict=True):
        alone = Simulator(two[:1])([{"sheath.pretension": pretension}])[0][0]
        np.testing.assert_array_equal(row[TENSION], alone[TENSION])


def test_what_is_known_of_each_recording_acts_on_it_alone() -> None:
    states = [bench("one", known={"sheath.extra_bend": b}) for b in (0.0, 1.0)]
    answers = Simulator(states)([{}])[0]
    for state, row in zip(states, answers, strict=True):
        np.testing.assert_array_equal(row[TENSION], replay_recording(state).columns[TENSION])


def test_a_session_s_value_is_applied_and_read_back(tmp_path) -> None:  # type: ignore[no-untyped-def]
    told = bench(
        "told",
        session={"output_tension.offset": Session(2.0, 0.5)},
        uncertain={"sheath*.friction": Uncertain(0.2, 0.1, 0.3, each=True)},
        hold=("input_displacement_m",),
        settle=0.25,
    )
    again = read_recording(write_recording(told, tmp_path / "told.csv"))
    assert again == told
    # the sheath's guess and settling apart, the offset shifts the reading
    plain = replay_recording(replace(told, session={}))
    shifted = replay_recording(told)
    np.testing.assert_allclose(shifted.columns[TENSION], plain.columns[TENSION] + 2.0, atol=1e-12)


def test_a_name_stands_for_all_that_fit_it() -> None:
    names = ["sheath_1.friction", "sheath_2.friction", "joint.friction", "a[1].friction"]
    assert matching("sheath_*.friction", names) == names[:2]
    assert matching("joint.friction", names) == ["joint.friction"]
    assert matching("a[1].friction", names) == ["a[1].friction"]  # a name goes before a pattern
    both = {"sheath_*.friction": 0.1, "sheath_2.friction": 0.2}
    assert expand(both, names) == {"sheath_1.friction": 0.1, "sheath_2.friction": 0.2}
    with refusing(UnknownNameError, "sheeth_*.friction"):
        matching("sheeth_*.friction", names)
    with refusing(RecordingError, "'one'", "sheeth_*.friction"):
        Simulator([bench("one", known={"sheeth_*.friction": 0.1})])


def test_a_held_drive_keeps_its_value_until_the_next_sample() -> None:
    """A staircase of samples that are dense in time is what a held drive means."""
    time = np.arange(0.0, 0.5, 0.05)
    steps = 5e-4 * np.sin(12.0 * time)
    columns = {"input_displacement_m": steps, TENSION: np.zeros(time.size)}
    held = bench("held", time=time, columns=columns, hold=("input_displacement_m",))
    dense = np.arange(0.0, 0.4501, 0.001)
    stairs = steps[np.minimum((dense + 1e-9) // 0.05, time.size - 1).astype(int)]
    fine = bench(
        "fine",
        time=dense,
        columns={"input_displacement_m": stairs, TENSION: np.zeros(dense.size)},
        hold=("input_displacement_m",),
    )
    answers = replay_recording(held).columns[TENSION]
    np.testing.assert_allclose(answers, replay_recording(fine).columns[TENSION][::50], atol=1e-9)
    smooth = replay_recording(replace(held, hold=())).columns[TENSION]
    assert float(np.abs(answers - smooth).max()) > 0.1


@pytest.mark.parametrize(
    ("changed", "facts"),
    [
        ({"hold": ("output_tension_N",)}, ["hold", "output_tension_N"]),
        ({"settle": -1.0}, ["settle", "-1.0"]),
        (
            {"known": {"a.b": 1.0}, "session": {"a.b": Session(1.0, 1.0)}},
            ["[session] 'a.b'", "[known]"],
        ),
        (
            {"uncertain": {"a.b": Uncertain(1.0, 0.0, 2.0)}, "session": {"a.b": Session(1.0, 1.0)}},
            ["[session] 'a.b'", "[uncertain]"],
        ),
    ],
)
def test_what_contradicts_itself_is_refused(changed: dict[str, object], facts: list[str]) -> None:
    with refusing(RecordingError, *facts):
        bench("wrong", **changed)
