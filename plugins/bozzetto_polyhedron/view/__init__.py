"""Scenes on the sheet and in space."""
