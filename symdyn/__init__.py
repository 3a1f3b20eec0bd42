"""symdyn: symbolic robot dynamics with drives, fast kernels, and a diagnosis of what a model lacks."""

__version__ = "0.1.0"
