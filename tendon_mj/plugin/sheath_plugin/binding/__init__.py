"""Binding of sheaths and sensors to their model, by name, by index and by signature."""
