"""Templates: nodes, edges, patches, and the rules that keep a car a car."""
