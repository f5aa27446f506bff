"""What Dask costs a sweep, and what is lost when workers and clients are killed."""
