"""What every page of HTML has: one file without network, one look, and texts that are escaped."""
