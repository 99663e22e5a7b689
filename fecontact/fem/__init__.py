"""From a mesh to numbers: stiffness, supports, rigid modes, condensation, loads, stresses."""
