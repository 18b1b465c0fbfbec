"""In the place of AlpaSim's map library: names that its runtime imports, and no maps."""
