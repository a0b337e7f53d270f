"""Correction of a curve by a stroke drawn over it, and the lift back into space."""
