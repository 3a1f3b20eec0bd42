// Pinocchio's algorithms, one state after the other, behind a C interface: compiled into a shared library.
#include "chain.hpp"

#include <pinocchio/algorithm/aba-derivatives.hpp>
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/rnea.hpp>

namespace {

using Row = Eigen::Map<const Eigen::VectorXd>;
using Column = Eigen::Map<Eigen::VectorXd>;
using Table = Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;

struct Arm {
    Arm(pinocchio::Model of, pinocchio::Convention way) : model(std::move(of)), data(model), convention(way) {}
    pinocchio::Model model;
    pinocchio::Data data;
    pinocchio::Convention convention;
};

template <typename Step>
void each(void* given, long count, const double* q, const double* qd, const double* third, double* out, int size, Step step)
{
    Arm& arm = *static_cast<Arm*>(given);
    const int n = arm.model.nv;
    for (long k = 0; k < count; ++k, q += n, qd += n, third += n, out += size)
        step(arm, Row(q, n), Row(qd, n), Row(third, n), out);
}

int joints(void* arm) { return static_cast<Arm*>(arm)->model.nv; }

} // namespace

extern "C" {

// local: the algorithms in joint frames; otherwise, where there are both, in the world frame (Pinocchio's default).
void* arm_new(int joints, const double* gravity, const double* numbers, int local)
{
    return new Arm(chain(joints, gravity, numbers), local ? pinocchio::Convention::LOCAL : pinocchio::Convention::WORLD);
}

void inverse_dynamics(void* arm, long count, const double* q, const double* qd, const double* qdd, double* out)
{
    const int n = joints(arm);
    each(arm, count, q, qd, qdd, out, n, [n](Arm& arm, auto q, auto v, auto a, double* out) {
        Column(out, n) = pinocchio::rnea(arm.model, arm.data, q, v, a);
    });
}

void mass_matrix(void* arm, long count, const double* q, const double* qd, const double* third, double* out)
{
    const int n = joints(arm);
    each(arm, count, q, qd, third, out, n * n, [n](Arm& arm, auto q, auto, auto, double* out) {
        pinocchio::crba(arm.model, arm.data, q, arm.convention);
        Table(out, n, n) = arm.data.M.selfadjointView<Eigen::Upper>();
    });
}

void forward_dynamics(void* arm, long count, const double* q, const double* qd, const double* tau, double* out)
{
    const int n = joints(arm);
    each(arm, count, q, qd, tau, out, n, [n](Arm& arm, auto q, auto v, auto t, double* out) {
        Column(out, n) = pinocchio::aba(arm.model, arm.data, q, v, t, arm.convention);
    });
}

void forward_dynamics_state_jacobian(
    void* arm, long count, const double* q, const double* qd, const double* tau, double* out)
{
    const int n = joints(arm);
    each(arm, count, q, qd, tau, out, 2 * n * n, [n](Arm& arm, auto q, auto v, auto t, double* out) {
        pinocchio::computeABADerivatives(arm.model, arm.data, q, v, t);
        Table jacobian(out, n, 2 * n);
        jacobian.leftCols(n) = arm.data.ddq_dq;
        jacobian.rightCols(n) = arm.data.ddq_dv;
    });
}
}
