"""Layers over the scene: wet ink, highlights, the loupe, the view cube."""
