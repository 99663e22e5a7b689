"""Front doors: the command line, scene files, ready studies, comparison."""
