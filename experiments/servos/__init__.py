"""Diagnoses of joints that a servo turns by cables that are not drawn."""
