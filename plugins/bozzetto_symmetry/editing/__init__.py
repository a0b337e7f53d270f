"""Steps that are kept beside the ink and done again. Imports fitting and below."""
