"""Refinement study of a user's scene: error against processor time and against degrees of freedom."""
