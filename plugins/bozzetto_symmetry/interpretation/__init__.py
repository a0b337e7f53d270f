"""What strokes mean: pair, single, crossing, in the plane. Imports stereo and below."""
