"""The command line: the same functions as the window, called with arguments."""
