"""Suites of recordings in which an effect is hidden, and the score of verdicts on them."""
