"""Long trials of the promises of docs/guarantees.md: hostile input, long runs, lives of models."""
