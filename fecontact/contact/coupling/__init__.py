"""Coupling of two surfaces: nodal forces or mortar, and choice of the slave."""
