"""Joints, bone weights and poses. Imports analysis and below."""
