"""Tables: what their tops are made of, and cloths and counters with the shapes of their own."""
