"""The point to mark next, and where it is expected. Imports body and below."""
