"""The panel of the window that shows the ranked answers."""
