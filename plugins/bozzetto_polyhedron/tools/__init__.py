"""The tools of the pen."""
