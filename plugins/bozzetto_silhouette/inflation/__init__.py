"""The height of one part over its outline. Imports implicit and below."""
