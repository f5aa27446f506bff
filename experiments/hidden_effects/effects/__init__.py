"""Effects, wrong numbers and disturbances that can be hidden in a reference."""
