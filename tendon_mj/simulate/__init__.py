"""Models, recordings, replay, and the bench held against theory."""
