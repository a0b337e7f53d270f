"""Plane curves out of samples: resampling, smoothing, crossings, spline fits."""
