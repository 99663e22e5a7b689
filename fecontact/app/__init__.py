"""Entry points: command line, scene files, ready studies, comparison of refinements."""
