"""The report of a diagnosis as one page."""
