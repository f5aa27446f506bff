"""What a sheath and its sensors belong to in their model, by name, by index and by signature."""
