"""From the recipe to exact bodies: each step remembered."""
