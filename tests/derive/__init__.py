"""Tests of the derivation: each formulation against another, closed forms, the seed paper, Pinocchio."""
