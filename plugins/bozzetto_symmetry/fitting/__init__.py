"""Symmetric splines fitted to ink in any number of views. Imports stereo and below."""
