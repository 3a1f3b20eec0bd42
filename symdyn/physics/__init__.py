"""The catalogue of physical effects: one file each in ``effects/``, found by looking, not by a list."""

from symdyn.physics.registry import catalogue, effect, schemas

__all__ = ["catalogue", "effect", "schemas"]
