"""The C ABI of MuJoCo: struct offsets, memory, functions of its library."""
