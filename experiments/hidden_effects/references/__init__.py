"""Independent references of the rigs, what drives them, and the sensors that read them."""
