"""The network as geometry: curves cut where they meet, mirror images among them."""
