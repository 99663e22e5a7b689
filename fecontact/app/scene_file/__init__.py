"""Scenes in TOML files."""
