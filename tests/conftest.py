"""Order of the tests: the longest come first, so that no worker is left alone with them."""

from pathlib import Path

EXPERIMENTS = Path(__file__).parent / "experiments"
LONGEST = EXPERIMENTS / "hidden_effects" / "test_quick_suite.py"


def pytest_collection_modifyitems(items):
    items.sort(key=lambda item: (item.path != LONGEST, EXPERIMENTS not in item.path.parents))
