"""The complementarity problem of bodies, contacts, springs and loads, and displacements of its solution."""
