"""Shared by all rooms: errors, material, checks, array types, units, text files, threads."""
