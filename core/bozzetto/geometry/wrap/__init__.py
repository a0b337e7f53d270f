"""A closed surface shrunk onto curves: from a sphere to the nearest fair skin."""
