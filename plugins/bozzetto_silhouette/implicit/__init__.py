"""Convolution and variational fields, and how they blend. Imports outline and below."""
