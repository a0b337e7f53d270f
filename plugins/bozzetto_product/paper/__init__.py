"""Surfaces as in the paper: triangles through a loop, the V-spring, and pressure on a membrane."""
