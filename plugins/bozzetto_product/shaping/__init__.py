"""Surfaces pressed out and in: their linear space searched for a volume."""
