"""Report of a diagnosis as an HTML page: its text, tables, charts and pictures."""
