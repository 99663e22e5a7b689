"""What may be wrong with a result although its certificate holds: one module a class of doubt."""
