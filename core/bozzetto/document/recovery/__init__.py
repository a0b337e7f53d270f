"""Recovery: the journal, locks, and what is found after a crash."""
