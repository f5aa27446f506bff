"""Making of hidden cases: plans, draws, strengths, recordings and keys."""
