"""The network MVTrans: as it was released, and corrected."""
