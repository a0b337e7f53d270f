"""From the state to curves in space. Imports editing and below."""
