"""Documents, modelers and pictures brought together, without a window."""
