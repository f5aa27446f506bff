"""Pictures: clips of a model in motion, and figures that hold it against theory and measurement."""
