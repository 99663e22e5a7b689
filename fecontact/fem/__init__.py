"""From a mesh to its stiffness, the factor, the Schur complement on some nodes, loads and stresses."""
