// Pinocchio's algorithms run once on CasADi's symbols; CasADi writes what they did as C.
//     casadi_trace NUMBERS FOLDER
// NUMBERS: joints, gravity, then those of chain.hpp.
#include <pinocchio/autodiff/casadi.hpp>

#include "chain.hpp"

#include <algorithm>
#include <fstream>
#include <iostream>
#include <pinocchio/algorithm/aba-derivatives.hpp>
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/rnea.hpp>

using casadi::Function;
using casadi::SX;
using Vector = Eigen::Matrix<SX, Eigen::Dynamic, 1>;
using Matrix = Eigen::Matrix<SX, Eigen::Dynamic, Eigen::Dynamic>;

namespace {

template <typename Entries>
SX by_rows(const Eigen::MatrixBase<Entries>& of) // one column, as arrays of C
{
    std::vector<SX> entries;
    for (Eigen::Index i = 0; i < of.rows(); ++i)
        for (Eigen::Index j = 0; j < of.cols(); ++j) entries.push_back(of(i, j));
    return SX::densify(SX::vertcat(entries));
}

SX by_rows(const SX& of) { return SX::densify(SX::vec(of.T())); }

Vector of_symbols(const SX& symbols)
{
    Vector found(symbols.rows());
    for (int i = 0; i < symbols.rows(); ++i) found(i) = symbols(i);
    return found;
}

} // namespace

int main(int, char** argument)
{
    std::ifstream file(argument[1]);
    int n;
    double number, gravity[3];
    file >> n >> gravity[0] >> gravity[1] >> gravity[2];
    std::vector<double> numbers;
    while (file >> number) numbers.push_back(number);
    const auto model = chain(n, gravity, numbers.data()).cast<SX>();
    pinocchio::DataTpl<SX> data(model);

    const SX q = SX::sym("q", n), qd = SX::sym("qd", n), third = SX::sym("third", n);
    const Vector eq = of_symbols(q), ev = of_symbols(qd), et = of_symbols(third);
    // Of several ways to the same values, the one that takes the fewest operations.
    const auto fewest = [&](const std::string& name, const std::vector<SX>& ways) {
        std::vector<Function> made;
        for (const auto& way : ways)
            made.push_back(Function(name, {q, qd, third}, {way}, casadi::Dict{{"cse", true}}));
        return *std::min_element(made.begin(), made.end(), [](const Function& a, const Function& b) {
            return a.n_instructions() < b.n_instructions();
        });
    };
    std::vector<SX> mass, acceleration, derivative;
    for (const auto convention : {pinocchio::Convention::WORLD, pinocchio::Convention::LOCAL}) {
        pinocchio::crba(model, data, eq, convention);
        mass.push_back(by_rows(Matrix(data.M.selfadjointView<Eigen::Upper>())));
        acceleration.push_back(by_rows(pinocchio::aba(model, data, eq, ev, et, convention)));
        derivative.push_back(by_rows(SX::jacobian(acceleration.back(), SX::vertcat({q, qd}))));
    }
    pinocchio::computeABADerivatives(model, data, eq, ev, et);
    Matrix own(n, 2 * n);
    own << data.ddq_dq, data.ddq_dv;
    derivative.push_back(by_rows(own));
    const std::vector<Function> found{
        fewest("inverse_dynamics", {by_rows(pinocchio::rnea(model, data, eq, ev, et))}),
        fewest("mass_matrix", mass),
        fewest("forward_dynamics", acceleration),
        fewest("forward_dynamics_state_jacobian", derivative),
    };

    casadi::CodeGenerator code("traced");
    for (const auto& each : found) {
        code.add(each);
        std::cout << each.name() << ' ' << each.n_instructions() << '\n';
    }
    code.generate(argument[2]);
}
