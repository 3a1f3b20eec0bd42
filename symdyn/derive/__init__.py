"""Derivation: from a robot and its effects to symbolic equations, with named intermediates."""
