"""From strokes to the lines of the two sides. Imports model."""
