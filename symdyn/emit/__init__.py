"""Emission: programs and equations become source text; the only layer that uses templates."""
