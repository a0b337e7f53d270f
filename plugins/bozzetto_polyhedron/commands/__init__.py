"""Commands, which need no gesture."""
