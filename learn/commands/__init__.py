"""The commands ``glassware train``, ``glassware evaluate`` and ``glassware predict``."""
