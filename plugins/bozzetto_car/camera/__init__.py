"""The camera of a sketch, and what it shows of a template. Imports template."""
