"""What every room needs and no room owns: errors, material, checks, array types, units, text files."""
