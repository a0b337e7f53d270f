"""The window for tests of plugins: the fixture `window`, loaded by pytest with the program."""
