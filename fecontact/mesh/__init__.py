"""What a body is cut into: nodes, elements, shapes, readers and writers of meshes, checks."""
