"""What every room needs and none owns: errors, material, checks, array types, units, text files."""
