"""Other ways to explain or predict the same recordings, with results in the same form."""
