"""The models of `models/` built from numbers, and the loading of any model."""
