"""Plugin of pytest: Hypothesis stops at the first example that fails, and does not make it smaller.

That a mutant's tests fail is enough; a smaller example takes minutes.
"""

from hypothesis import Phase, settings

settings.register_profile("first_failure", phases=[Phase.explicit, Phase.generate])
settings.load_profile("first_failure")
