"""Measures of a solid against its drawing, and its report. Imports solids and below."""
