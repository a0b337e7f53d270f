"""The canvas: the viewport where people draw."""
