"""Ready studies: a function each, which returns a `Study`."""
