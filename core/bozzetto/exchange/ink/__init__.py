"""Formats of recorded ink: JSON and InkML."""
