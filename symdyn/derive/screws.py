"""Twists and wrenches, and how they are handed from one joint frame to the next."""

from __future__ import annotations

from dataclasses import dataclass

import sympy as sp

from symdyn.derive.joint_frames import JointFrame
from symdyn.derive.steps import Steps

Z = sp.ImmutableMatrix([0, 0, 1])


@dataclass(frozen=True, slots=True)
class Twist:
    """Angular velocity (3,), and velocity (3,) of the point at the frame's origin, in the axes of the frame."""

    omega: sp.Matrix
    velocity: sp.Matrix


@dataclass(frozen=True, slots=True)
class Wrench:
    """Force (3,), and moment (3,) about the frame's origin, in the axes of the frame."""

    force: sp.Matrix
    moment: sp.Matrix


@dataclass(frozen=True, slots=True)
class Joint:
    """A joint frame and what it takes to cross it: ``turn`` (3, 3) is the rotation by its angle, ``label`` its link."""

    frame: JointFrame
    turn: sp.Matrix
    label: str

    def vector_inwards(self, name: str, vector: sp.Matrix, law: str, steps: Steps) -> sp.Matrix:
        """From this frame to the axes of the one before."""
        turned = steps.vector(name, self.turn * vector, law)
        return steps.vector(f"{name}t", self.frame.twist * turned, law)

    def vector_outwards(self, name: str, vector: sp.Matrix, law: str, steps: Steps) -> sp.Matrix:
        """From the axes of the frame before to this one."""
        twisted = steps.vector(f"{name}t", self.frame.twist.T * vector, law)
        return steps.vector(f"{name}r", self.turn.T * twisted, law)

    def inwards(self, name: str, wrench: Wrench, law: str, steps: Steps) -> Wrench:
        """From this frame to the one before."""
        force = self.vector_inwards(f"{name}_f", wrench.force, law, steps)
        moment = self.vector_inwards(f"{name}_n", wrench.moment, law, steps)
        return Wrench(force, steps.vector(f"{name}_b", moment + self.frame.position.cross(force), law))

    def outwards(self, name: str, twist: Twist, law: str, steps: Steps) -> Twist:
        """From the frame before to this one."""
        velocity = steps.vector(f"{name}_b", twist.velocity + twist.omega.cross(self.frame.position), law)
        omega = self.vector_outwards(f"{name}_o", twist.omega, law, steps)
        return Twist(omega, self.vector_outwards(f"{name}_v", velocity, law, steps))


def power(twist: Twist, wrench: Wrench) -> sp.Expr:
    """What the wrench does on the twist."""
    return twist.omega.dot(wrench.moment) + twist.velocity.dot(wrench.force)


def skew(v: sp.Matrix) -> sp.Matrix:
    """The matrix of the cross product: skew(v) r = v x r."""
    return sp.Matrix([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
