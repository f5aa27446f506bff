"""Long trials of what docs/guarantees.md promises: hostile input, long runs, lives of models."""
