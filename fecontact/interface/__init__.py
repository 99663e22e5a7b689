"""What lies between two bodies: surfaces, feet, pairs, candidates."""
