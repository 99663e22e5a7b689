"""Surfaces of rigid bodies: simple shapes, height maps, triangulated, rough and measured ones."""
