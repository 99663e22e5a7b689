"""The front doors: command line, scene files, ready studies, comparison of refinements."""
