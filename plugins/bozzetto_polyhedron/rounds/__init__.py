"""Ellipses and arcs of a line drawing: what of it is round, and what that makes of a body."""
