"""The surfaces of a solved car, and edits of them. Imports solver and below."""
