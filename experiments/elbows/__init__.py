"""Elbows with two cables in sheaths, simulated independently, and their diagnoses."""
