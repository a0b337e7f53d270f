"""The state of a drawing, its planes and view rays. Imports no other room."""
