"""The reference elements: shape functions, quadrature, degenerate hexahedra."""
