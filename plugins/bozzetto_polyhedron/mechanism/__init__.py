"""Rigid bodies on joints, moved in time with their lengths kept."""
