"""Surfaces cut into charts that lie flat in one square picture."""
