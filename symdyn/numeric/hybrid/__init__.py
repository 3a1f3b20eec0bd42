"""Simulation that is exact about events: modes, guards, and propagation between them."""
