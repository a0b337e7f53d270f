"""Exact shapes: rational B-spline surfaces, trimmed to faces that share their edges."""
