"""Noise of a measured series, where it is known."""

from __future__ import annotations

import numpy as np
import pytest

from tendon_mj.lab.recordings import estimate_noise


@pytest.mark.parametrize("level", [0.003, 0.05, 1.0])
def test_noise_is_found_under_motion(level: float) -> None:
    random = np.random.default_rng(7)
    time = np.linspace(0.0, 8.0, 2000)
    series = 20.0 * np.sin(2.0 * time) + random.normal(0.0, level, time.size)
    assert estimate_noise(series) == pytest.approx(level, rel=0.1)


def test_noise_of_a_quantised_series_is_at_least_its_rounding() -> None:
    series = np.round(np.sin(np.linspace(0.0, 6.0, 2000)), 3)
    assert estimate_noise(series) >= 0.9 * 1e-3 / np.sqrt(12.0)


def test_noise_of_a_coarsely_quantised_series_is_its_rounding() -> None:
    series = np.round(20.0 * np.sin(np.linspace(0.0, 60.0, 2000)) / 5.0) * 5.0
    assert estimate_noise(series) == pytest.approx(5.0 / np.sqrt(12.0))


def test_even_steps_are_no_rounding() -> None:
    triangle = np.concatenate([np.arange(0.0, 1.0, 0.01), np.arange(1.0, 0.0, -0.01)])
    assert estimate_noise(triangle) < 1e-9
