"""Indentation of half-spaces."""
