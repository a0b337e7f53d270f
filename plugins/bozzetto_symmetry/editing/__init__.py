"""Changes of curves that are kept beside the ink and replayed. Imports fitting and below."""
