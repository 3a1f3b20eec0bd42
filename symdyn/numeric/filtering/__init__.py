"""Recordings of part of a machine: Kalman filters on its emitted equations, and what they tell of missing physics."""
