"""Recordings: a table of measured columns with a description of what they are."""
