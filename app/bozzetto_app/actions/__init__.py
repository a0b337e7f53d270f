"""One record for each thing a person can do, and the menus made from them."""
