"""The catalogue of physical effects: one file each in ``effects/``, found by looking, not by a list."""

from symdyn.physics.registry import catalogue, effect, load_dependent, schemas

__all__ = ["catalogue", "effect", "load_dependent", "schemas"]
