"""Strokes on a body after it was reconstructed."""
