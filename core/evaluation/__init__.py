"""Measures of a bake, with their floors in true motion."""
