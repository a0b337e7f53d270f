"""Meanings of strokes: pair, single, across, in the plane. Imports stereo and below."""
