"""From ink to curves in space: order, fit, depth."""
