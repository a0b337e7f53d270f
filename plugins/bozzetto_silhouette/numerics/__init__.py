"""Interpolation on grids and remeshing. Imports no other room."""
