"""Outlines of text."""
