"""Data of a diagnosis: recordings as residuals in units of noise, and their regimes."""
