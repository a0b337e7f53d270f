"""Merging: several strokes, drawn over one another in any order, become one curve."""
