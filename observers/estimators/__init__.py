"""The filter and the window: linear algebra, one step of each, and the observers made of them."""
