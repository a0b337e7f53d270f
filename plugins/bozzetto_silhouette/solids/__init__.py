"""Bodies of one or many parts and the set operations. Imports inflation and below."""
