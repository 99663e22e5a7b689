"""What a solution tells: fields, resultants, warnings, tables, pictures, files."""
