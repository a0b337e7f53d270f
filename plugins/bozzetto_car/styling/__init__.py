"""Curves drawn on the body. Imports body and below."""
