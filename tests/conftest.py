"""Order of the tests, the longest first, so that no worker is left alone with them; no time limits.

A machine that does other work, too, is slow at any moment.
"""

from pathlib import Path

from hypothesis import HealthCheck, settings

settings.register_profile(
    "without a time limit", deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("without a time limit")

EXPERIMENTS = Path(__file__).parent / "experiments"
LONGEST = EXPERIMENTS / "hidden_effects" / "test_quick_suite.py"


def pytest_collection_modifyitems(items):
    items.sort(key=lambda item: (item.path != LONGEST, EXPERIMENTS not in item.path.parents))
