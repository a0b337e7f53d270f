"""Work off the window's thread: queues, time limits, the way back."""
