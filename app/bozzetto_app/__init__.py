"""The Qt shell of Bozzetto: one window around the core."""
