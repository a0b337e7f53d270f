"""Cameras and shape from marks. Imports camera and below."""
