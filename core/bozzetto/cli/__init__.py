"""The command line: the same functions as the window, called with arguments."""

COMMANDS = ("build", "trace", "export", "render", "simulate", "info", "samples", "plugins")
"""Words after which no window opens."""

SWITCHES = ("-v", "--verbose")
"""Words that may stand before a command."""
