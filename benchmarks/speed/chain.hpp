// A serial arm of revolute joints from plain numbers, as a Pinocchio model.
#pragma once
#include <pinocchio/multibody.hpp>

// Per joint: placement in the last joint's frame (rotation by rows, position), then mass, centre of mass and inertia
// about it (xx, xy, yy, xz, yz, zz) in the joint's own frame. Every joint turns about z.
constexpr int NUMBERS = 12 + 10;

inline pinocchio::Model chain(int joints, const double* gravity, const double* numbers)
{
    pinocchio::Model model;
    model.gravity.linear() = Eigen::Map<const Eigen::Vector3d>(gravity);
    pinocchio::JointIndex parent = 0;
    for (int i = 0; i < joints; ++i, numbers += NUMBERS) {
        const Eigen::Matrix3d rotation = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(numbers);
        const Eigen::Vector3d position = Eigen::Map<const Eigen::Vector3d>(numbers + 9), com(numbers + 13);
        const double* moments = numbers + 16;
        const pinocchio::Symmetric3 inertia(moments[0], moments[1], moments[2], moments[3], moments[4], moments[5]);
        const pinocchio::SE3 placement(rotation, position);
        parent = model.addJoint(parent, pinocchio::JointModelRZ(), placement, "joint" + std::to_string(i + 1));
        model.appendBodyToJoint(parent, pinocchio::Inertia(numbers[12], com, inertia), pinocchio::SE3::Identity());
    }
    return model;
}
