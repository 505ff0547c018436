"""How good what a network finds is. Each module is one family of figures; all of them are on arrays of NumPy."""
