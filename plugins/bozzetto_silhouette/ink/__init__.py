"""From strokes to closed rings. Imports numerics and the core."""
