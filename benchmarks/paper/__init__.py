"""The seed's paper computed again: docs/paper.md and its figures (python -m benchmarks.paper)."""
