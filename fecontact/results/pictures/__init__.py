"""Pictures of results: contact maps, bodies, curves."""
