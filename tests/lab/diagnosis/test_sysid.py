"""Fits of mujoco.sysid on a rig whose parameters are known."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tendon_mj.errors import TendonError
from tendon_mj.lab.diagnosis import fit_with_sysid, sysid, sysid_is_there
from tendon_mj.lab.recordings import Recording, Uncertain
from tendon_mj.lab.replay import Parameter, Simulates
from tests.lab.recorded import recorded
from tests.refusals import refusing

needs_sysid = pytest.mark.skipif(not sysid_is_there(), reason="mujoco.sysid lacks its extras")

NOISE = 0.05
UNCERTAIN = {"tendon.stiffness": Uncertain(1.5e3, 1e3, 3e3), "tendon.friction": Uncertain(1, 0, 5)}


class Toy(Simulates):
    """Tension = stiffness × displacement + friction × direction; 3 N of nothing it knows of."""

    def __init__(self, recordings: Sequence[Recording]) -> None:
        self.recordings = recordings
        self.parameters = {n: Parameter(u.value, "", "live") for n, u in UNCERTAIN.items()}

    def __call__(self, sets: Sequence[Mapping[str, float]]) -> list[list[dict[str, np.ndarray]]]:
        return [
            [self.answer(recording, values) for recording in self.recordings] for values in sets
        ]

    def answer(self, recording: Recording, values: Mapping[str, float]) -> dict[str, np.ndarray]:
        given = {name: p.value for name, p in self.parameters.items()} | dict(values)
        return {
            "tension_N": tension(
                recording.columns["displacement_m"],
                given["tendon.stiffness"],
                given["tendon.friction"],
            )
        }


def tension(displacement, stiffness, friction):
    return stiffness * displacement + friction * np.sign(np.gradient(displacement))


def record(seed, stiffness=2e3, friction=2.0, bias=0.0, uncertain=UNCERTAIN):
    random = np.random.default_rng(seed)
    time = np.linspace(0.0, 6.0, 900)
    x = 5e-3 * np.sin(2.0 * np.pi * random.uniform(0.3, 0.6) * time)
    y = tension(x, stiffness, friction) + bias + random.normal(0.0, NOISE, time.size)
    return recorded(
        time,
        {"displacement_m": ("drive", x)},
        {"tension_N": ("tension", NOISE, y)},
        "toy",
        name=f"toy_{seed}",
        uncertain=uncertain,
    )


@needs_sysid
def test_what_was_planted_is_recovered_down_to_the_noise():
    result = fit_with_sysid([record(1), record(2)], [record(3)], simulator=Toy)
    for name, truth in (("tendon.stiffness", 2e3), ("tendon.friction", 2.0)):
        value, low, high = result.values[name]
        assert value == pytest.approx(truth, rel=0.02)
        assert low < value < high
    assert result.train_rms == pytest.approx(1.0, abs=0.1)
    assert result.held_out_rms == pytest.approx(1.0, abs=0.1)
    assert result.signals["tension_N"] == pytest.approx(NOISE, rel=0.1)


@needs_sysid
def test_what_the_model_lacks_stays_in_the_error():
    bias = 20.0 * NOISE
    result = fit_with_sysid(
        [record(1, bias=bias), record(2, bias=bias)], [record(3, bias=bias)], simulator=Toy
    )
    assert result.held_out_rms == pytest.approx(bias / NOISE, rel=0.1)


@needs_sysid
def test_values_stay_in_the_ranges_of_the_recordings():
    result = fit_with_sysid([record(1, stiffness=9e3)], [record(2, stiffness=9e3)], simulator=Toy)
    for name, (value, low, high) in result.values.items():
        assert UNCERTAIN[name].low <= low <= value <= high <= UNCERTAIN[name].high
    assert result.values["tendon.stiffness"][0] == pytest.approx(3e3, rel=1e-3)


@needs_sysid
def test_without_a_hold_out_the_tails_are_kept_from_the_fit():
    spoilt = record(1)
    columns = {c: values.copy() for c, values in spoilt.columns.items()}
    columns["tension_N"][-200:] += 50.0 * NOISE
    plain = {f: getattr(spoilt, f) for f in ("model", "source", "time", "drive", "measured")}
    tail = Recording(name="tail", columns=columns, uncertain=UNCERTAIN, **plain)
    result, clean = (fit_with_sysid([r], simulator=Toy) for r in (tail, spoilt))
    assert result.values == clean.values
    assert result.train_rms == clean.train_rms
    assert result.held_out_rms > 10.0 * clean.held_out_rms


@needs_sysid
def test_of_different_states_each_is_predicted_by_a_fit_to_the_others():
    three = [replace(record(k), known={"rig.bend": float(k)}) for k in (1, 2, 3)]
    assert fit_with_sysid(three, simulator=Toy).held_out_rms == pytest.approx(1.0, abs=0.1)
    columns = {**three[2].columns, "tension_N": three[2].columns["tension_N"] + 50.0 * NOISE}
    spoilt = fit_with_sysid([*three[:2], replace(three[2], columns=columns)], simulator=Toy)
    assert spoilt.held_out_rms > 50.0 / np.sqrt(3.0)  # the fit has not seen it
    assert spoilt.train_rms < spoilt.held_out_rms


@needs_sysid
def test_where_nothing_is_uncertain_nothing_is_fitted():
    result = fit_with_sysid([record(1, uncertain={})], [record(2, uncertain={})], simulator=Toy)
    assert result.values == {}
    assert "nothing was fitted" in result.note


@needs_sysid
def test_progress_ends_at_its_total():
    seen = []
    fit_with_sysid([record(1)], [record(2)], lambda *told: seen.append(told), simulator=Toy)
    assert all(label == "mujoco.sysid" for label, _, _ in seen)
    assert all(done <= total for _, done, total in seen)
    assert seen[-1][1] == seen[-1][2]


def test_without_its_extras_the_message_says_what_to_install(monkeypatch):
    monkeypatch.setattr(sysid, "sysid", SimpleNamespace())
    with refusing(TendonError, "pip install 'tendon-mj[sysid]'"):
        fit_with_sysid([record(1)], simulator=Toy)
