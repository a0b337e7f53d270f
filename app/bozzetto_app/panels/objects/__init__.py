"""The list of objects and their parts."""
