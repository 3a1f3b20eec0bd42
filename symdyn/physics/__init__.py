"""The catalogue of physical effects: one file each in ``effects/``, found by looking, not by a list."""

from symdyn.physics.registry import catalogue, effect, in_stages, law_variables, load_dependent, schemas, with_play

__all__ = ["catalogue", "effect", "in_stages", "law_variables", "load_dependent", "schemas", "with_play"]
