"""Bicubic patches: evaluation, joints, curvature, nearest points, rays."""
