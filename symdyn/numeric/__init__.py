"""Numbers only: recordings, simulation, frequency response, regression and diagnosis; no SymPy."""
