"""The bundled arms of four to seven axes as their sources print them, in Pinocchio, and not through any robot.toml."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

State = dict[str, list[float]]


def _body(pin: Any, mass: float, com: Sequence[float], moments: Sequence[float], products: Sequence[float]) -> Any:
    """``moments``: xx, yy, zz; ``products``: xy, xz, yz; about the centre of mass."""
    (xx, yy, zz), (xy, xz, yz) = moments, products
    return pin.Inertia(mass, np.array(com, float), np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], float))


# Kinematics of franka_description (robots/fer/kinematics.yaml): xyz and roll of each joint, seen from the last.
_PANDA_JOINTS = (
    ((0, 0, 0.333), 0),
    ((0, 0, 0), -1),
    ((0, -0.316, 0), 1),
    ((0.0825, 0, 0), 1),
    ((-0.0825, 0.384, 0), -1),
    ((0, 0, 0), 1),
    ((0.088, 0, 0), 1),
)
# Mass, centre of mass and inertia (xx, xy, xz, yy, yz, zz) of FrankaEmikaPandaDynModel, DynPars2VREP.m. The height of
# the first centre of mass is that of the URDF in example-robot-data; no torque may depend on it.
_PANDA_LINKS = (
    (4.970684, (3.875e-3, 2.081e-3, -0.04762), (0.70337, -0.000139, 0.006772, 0.70661, 0.019169, 0.009117)),
    (0.646926, (-3.141e-3, -2.872e-2, 3.495e-3), (0.007962, -0.003925, 0.010254, 0.02811, 0.000704, 0.025995)),
    (3.228604, (2.7518e-2, 3.9252e-2, -6.6502e-2), (0.037242, -0.004761, -0.011396, 0.036155, -0.012805, 0.01083)),
    (3.587895, (-5.317e-2, 1.04419e-1, 2.7454e-2), (0.025853, 0.007796, -0.001332, 0.019552, 0.008641, 0.028323)),
    (1.225946, (-1.1953e-2, 4.1065e-2, -3.8437e-2), (0.035549, -0.002117, -0.004037, 0.029474, 0.000229, 0.008627)),
    (1.666555, (6.0149e-2, -1.4117e-2, -1.0517e-2), (0.001964, 0.000109, -0.001158, 0.004354, 0.000341, 0.005433)),
    (0.735522, (1.0517e-2, -4.252e-3, 6.1597e-2), (0.012516, -0.000428, -0.001196, 0.010027, -0.000741, 0.004815)),
)


def panda(pin: Any) -> Any:
    model = pin.Model()
    model.gravity = pin.Motion(np.array([0, 0, -9.81]), np.zeros(3))
    parent = 0
    for (xyz, quarters), (mass, com, (xx, xy, xz, yy, yz, zz)) in zip(_PANDA_JOINTS, _PANDA_LINKS, strict=True):
        place = pin.SE3(
            pin.AngleAxis(quarters * np.pi / 2, np.array([1.0, 0, 0])).toRotationMatrix(), np.array(xyz, float)
        )
        parent = model.addJoint(parent, pin.JointModelRZ(), place, f"joint{parent + 1}")
        model.appendBodyToJoint(parent, _body(pin, mass, com, (xx, yy, zz), (xy, xz, yz)), pin.SE3.Identity())
    return model


# Modelica Standard Library, RobotR3: all frames parallel at q = 0, y upwards; r is where the next joint sits.
_R3_BASE = (0, 0.351, 0)
_R3 = (
    # axis, r, mass, centre of mass, (I_11, I_22, I_33), I_21
    ("y", (0, 0.324, 0.3), 0, (0, 0, 0), (0, 1.16, 0), 0),
    ("x", (0, 0.65, 0), 56.5, (0.172, 0.205, 0), (2.58, 0.64, 2.73), -0.46),
    ("x", (0, 0.414, -0.155), 26.4, (0.064, -0.034, 0), (0.279, 0.245, 0.413), -0.070),
    ("y", (0, 0.186, 0), 28.7, (0, 0, 0), (1.67, 0.081, 1.67), 0),
    ("x", (0, 0.125, 0), 5.2, (0, 0, 0), (1.25, 0.81, 1.53), 0),
    ("y", (0, 0, 0), 0.5, (0.05, 0.05, 0.05), (0, 0, 0), 0),
)


def manutec_r3(pin: Any) -> Any:
    model = pin.Model()
    model.gravity = pin.Motion(np.array([0, -9.81, 0]), np.zeros(3))
    parent = 0
    place: Sequence[float] = _R3_BASE
    for axis, r, mass, com, moments, i_21 in _R3:
        joint = pin.JointModelRX() if axis == "x" else pin.JointModelRY()
        parent = model.addJoint(parent, joint, pin.SE3(np.eye(3), np.array(place, float)), f"r{parent + 1}")
        model.appendBodyToJoint(parent, _body(pin, mass, com, moments, (i_21, 0, 0)), pin.SE3.Identity())
        place = r
    return model


# ST24R, E655a: everything in the spatial frame at the home position, y upwards.
_SCARA = (
    # axis, point on it, mass, centre of mass, moments of inertia
    ("turns", 1, (0, 0.192, 0), 7, (0.2, 0.2, 0), (0.1, 0.3, 0.2)),
    ("turns", 1, (0.4, 0, 0), 5, (0.5, 0.258, 0), (0.1, 0.5, 0.3)),
    ("slides", 1, (0.65, 0.36, 0), 1, (0.65, 0.258, 0), (0.1, 0.1, 0.1)),
    ("turns", -1, (0.65, 0.26, 0), 0.5, (0.65, 0.208, 0), (0.1, 0.1, 0.1)),
)


def scara(pin: Any) -> Any:
    """The book counts the third joint upwards: its q_3 and effort are the negatives of the file's."""
    model = pin.Model()
    model.gravity = pin.Motion(np.array([0, -9.81, 0]), np.zeros(3))
    parent, last = 0, np.zeros(3)
    for kind, sign, point, mass, com, moments in _SCARA:
        here, up = np.array(point, float), np.array([0.0, sign, 0.0])
        joint = pin.JointModelPrismaticUnaligned(up) if kind == "slides" else pin.JointModelRevoluteUnaligned(up)
        parent = model.addJoint(parent, joint, pin.SE3(np.eye(3), here - last), f"joint{parent + 1}")
        model.appendBodyToJoint(parent, _body(pin, mass, np.array(com) - here, moments, (0, 0, 0)), pin.SE3.Identity())
        last = here
    return model


# Robotics Toolbox for Python 1.5.0: (q, qd, qdd), rne(q, qd, qdd) in 13 digits, made with
#
#     import numpy as np, roboticstoolbox as rtb
#     def show(robot, rng, count):
#         for _ in range(count):
#             q, qd, qdd = (np.round(rng.uniform(-2, 2, 6), 2) for _ in range(3))
#             print(q, qd, qdd, robot.rne(q, qd, qdd))
#     show(rtb.models.DH.Puma560(), np.random.default_rng(560), 4)
#     rng = np.random.default_rng(1981)
#     stanford = rtb.models.DH.Stanford()
#     for link in stanford.links[1:]:
#         link.r = link.r / 10                     # see stanford.toml
#     show(stanford, rng, 2)
#     show(ur10e, rng, 2)                          # DHRobot of RevoluteDH(d, a, alpha, m, r, I) with UR's numbers
#
# rne adds the rotors (G^2 Jm qdd) and the friction (|G| (B |G| qd + Tc), Tc by the sign of qd) of the Puma, and the
# motors of the Stanford arm, to the rigid arm's efforts.
TOOLBOX: dict[str, list[tuple[State, list[float]]]] = {
    "puma560": [
        (
            {
                "q": [-0.1, -1.96, 0.09, -1.41, -1.28, 0.25],
                "qd": [0.13, 0.38, 1.82, 1.96, -0.69, -1.19],
                "qdd": [-0.84, 0.92, 0.46, -1.61, 1.09, 1.69],
            },
            [23.39909284241, 14.11374388842, 23.37742646598, 1.32285628873, -1.159476744511, -0.7340213892035],
        ),
        (
            {
                "q": [-1.34, -1.13, -1.58, -1.24, -0.31, -1.05],
                "qd": [-0.84, -0.61, 1.32, 0.59, 0.16, -1.59],
                "qdd": [-0.87, -1.49, -0.78, 1.45, -0.62, -0.93],
            },
            [-35.45157363883, -2.9045008639, 13.63212312817, 1.372564790081, 0.6201564555323, -1.328827351895],
        ),
        (
            {
                "q": [-0.47, 0.7, 1.78, -0.35, 1.24, 1.08],
                "qd": [1.86, -0.17, -0.76, 0.57, 0.22, -1.49],
                "qdd": [1.57, 0.1, 1.02, 1.76, -0.77, -1.5],
            },
            [40.57102278308, 14.79911646125, -13.33134085449, 1.421004559556, 0.6455980356655, -1.418035112191],
        ),
        (
            {
                "q": [-0.82, 1.81, 1.47, -0.53, 0.03, -1.38],
                "qd": [-0.2, 0.04, 0.89, 1.63, 0.35, -1.82],
                "qdd": [-1.8, -1.91, 0.97, -1.48, -0.95, -1.73],
            },
            [-31.59422490578, -1.021194164892, 12.30073979985, 1.240569035433, 0.657000594501, -1.533797051311],
        ),
    ],
    "stanford": [
        (
            {
                "q": [-0.56, -1.46, 0.62, 1.83, -1.65, 1.83],
                "qd": [-0.29, -0.17, -1.15, 0.2, 0.83, 0.86],
                "qdd": [-0.56, -1.21, -1.88, -1.53, 0.79, 0.77],
            },
            [-3.698936316515, 5.991275005562, -7.270141694699, -0.2742994856205, -0.05716121049198, 0.01597627579441],
        ),
        (
            {
                "q": [0.26, 1.58, 0.33, 1.85, -1.87, 1.8],
                "qd": [0.19, -0.24, -1.65, -0.63, -0.45, 0.72],
                "qdd": [0.91, -1.54, 0.09, 0.13, -1.78, 1.85],
            },
            [4.625668636842, -2.566091716371, -0.9346634392091, 0.1401857367705, -0.05534919032976, 0.03795214033042],
        ),
    ],
    "ur10e": [
        (
            {
                "q": [1.83, -1.48, 1.63, 0.55, 1.4, -1.2],
                "qd": [1.46, 0.43, -0.86, -1.82, 1.09, 1.81],
                "qdd": [1.84, 0.16, 1.38, 1.74, 1.6, -1.54],
            },
            [10.82231306626, -48.73531344627, -33.27843042166, 1.95296191097, -0.3348466523464, 0.0008877811847349],
        ),
        (
            {
                "q": [0.67, 1.6, -1.43, 1.29, 0.56, 0.02],
                "qd": [0.78, -1.68, -1.88, -1.55, -0.4, 1.55],
                "qdd": [1.73, 1.23, -1.17, -0.79, -0.19, -1.31],
            },
            [19.12948054043, -4.340720765068, -41.67133791913, 4.886069728625, -1.283057145304, -0.001177246519023],
        ),
    ],
}
