"""From bodies, contacts, springs and loads to one complementarity problem, and back to displacements."""
