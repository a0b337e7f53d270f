"""Loops of a net: found, oriented alike, named by curves and joints."""
