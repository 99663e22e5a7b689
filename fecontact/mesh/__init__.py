"""Meshes: nodes, elements, shapes, readers and writers, checks."""
