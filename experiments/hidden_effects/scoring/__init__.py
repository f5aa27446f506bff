"""Comparison of verdicts with keys: judged cases, rates, tables."""
