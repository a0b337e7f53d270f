"""The panel of the window that shows the motion of a shape."""
