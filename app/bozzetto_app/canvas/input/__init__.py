"""From Qt's events to strokes, taps and drags."""
