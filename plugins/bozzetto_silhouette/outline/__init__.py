"""Outlines with holes: triangulation, distances, skeleton. Imports ink and below."""
