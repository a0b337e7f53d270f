"""From strokes to lines that meet in corners."""
