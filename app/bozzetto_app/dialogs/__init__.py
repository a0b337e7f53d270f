"""The dialogs: for what needs an answer, or a place of its own."""
