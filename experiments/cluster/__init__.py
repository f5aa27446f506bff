"""Cost of Dask in a sweep, and losses when workers and clients are killed."""
