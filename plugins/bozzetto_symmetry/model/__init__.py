"""The state of a drawing: box, plane, axes. Imports no other room."""
