"""Effects that a diagnosis can name: their types, where they bind to a model, and the catalogue."""
