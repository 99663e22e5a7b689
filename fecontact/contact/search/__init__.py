"""Which parts of two surfaces may touch: search regions, bounds, candidates."""
