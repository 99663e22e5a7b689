"""Ready studies of friction on half-spaces."""
