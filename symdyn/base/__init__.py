"""What every layer may use: errors with places, units, symbols, non-smooth primitives, safe files."""
