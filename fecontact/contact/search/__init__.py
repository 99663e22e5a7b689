"""Contact search: regions that may touch, bounds, candidates."""
