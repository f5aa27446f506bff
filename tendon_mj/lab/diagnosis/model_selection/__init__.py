"""Model selection: which effects, added to the calibrated model, the training data call for."""
