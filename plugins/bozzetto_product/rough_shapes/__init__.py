"""Rough shapes to draw on, by formulas."""
