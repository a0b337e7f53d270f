"""From the recipe to nets, loops and surfaces."""
