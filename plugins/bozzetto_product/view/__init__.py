"""A product as it is shown."""
