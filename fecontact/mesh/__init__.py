"""What a body is cut into: elements, shapes, checks."""
