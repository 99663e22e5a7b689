"""Checks of a certified result for modelling and discretisation errors, one module for each kind."""
