"""Results of a solution: fields, resultants, warnings, tables, pictures, files."""
