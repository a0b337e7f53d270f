"""The form of parameters and the report of figures."""
