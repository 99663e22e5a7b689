"""A user's own scene, refined: error against processor time and against degrees of freedom."""
