"""Finite elements: stiffness of a mesh, factorisation, Schur complement, loads and stresses."""
