/* SPDX-License-Identifier: MIT
 *
 * The fastest timing of given rows by toppra's C++ core (Seidel, interpolation scheme), for one_arm_timing.py, which
 * compiles this where toppra is installed. Standard input: N + 1, m, repeats, then grid points, lower and upper limits,
 * and a, b, c of every grid point, all as doubles. Prints the median CPU time of a whole call [s] and the duration [s].
 */
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <memory>
#include <vector>

#include <toppra/algorithm/toppra.hpp>
#include <toppra/constraint.hpp>
#include <toppra/geometric_path/piecewise_poly_path.hpp>
#include <toppra/solver/seidel.hpp>

using toppra::Bounds;
using toppra::Matrices;
using toppra::Matrix;
using toppra::Vector;
using toppra::Vectors;

/* lower <= a u + b x + c <= upper, everything given. */
class GivenRows : public toppra::LinearConstraint {
  public:
    Vectors of_u, of_x, rest;
    Vector lower, upper;

    explicit GivenRows(int rows) : LinearConstraint(2 * rows, rows, true, false, false) {
        discretizationType(toppra::Interpolation);
    }

  protected:
    void computeParams_impl(const toppra::GeometricPath &, const Vector &, Vectors &a, Vectors &b, Vectors &c, Matrices &F,
                            Vectors &g, Bounds &, Bounds &) override {
        const auto rows = nbVariables();
        for (std::size_t i = 0; i < a.size(); ++i) {
            a[i] = of_u[i];
            b[i] = of_x[i];
            c[i] = rest[i];
        }
        F[0].topRows(rows).setIdentity();
        F[0].bottomRows(rows) = -Matrix::Identity(rows, rows);
        g[0].head(rows) = upper;
        g[0].tail(rows) = -lower;
    }
};

static Vector read_vector(int size) {
    Vector values(size);
    if (std::fread(values.data(), sizeof(double), static_cast<std::size_t>(size), stdin) != static_cast<std::size_t>(size))
        std::exit(2);
    return values;
}

int main() {
    const Vector head = read_vector(3);
    const int points = static_cast<int>(head[0]), rows = static_cast<int>(head[1]), repeats = static_cast<int>(head[2]);
    const Vector grid = read_vector(points);
    auto constraint = std::make_shared<GivenRows>(rows);
    constraint->lower = read_vector(rows);
    constraint->upper = read_vector(rows);
    for (Vectors *part : {&constraint->of_u, &constraint->of_x, &constraint->rest})
        for (int i = 0; i < points; ++i) part->push_back(read_vector(rows));
    Matrix line(2, 1);
    line << 1.0, 0.0;
    auto path = std::make_shared<toppra::PiecewisePolyPath>(Matrices{line}, std::vector<double>{grid[0], grid[points - 1]});
    std::vector<double> times;
    double duration = 0;
    for (int repeat = 0; repeat <= repeats; ++repeat) {
        const std::clock_t start = std::clock();
        toppra::algorithm::TOPPRA algorithm({constraint}, path);
        algorithm.setGridpoints(grid);
        algorithm.solver(std::make_shared<toppra::solver::Seidel>());
        if (algorithm.computePathParametrization(0, 0) != toppra::ReturnCode::OK) return 1;
        const double taken = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
        if (repeat) times.push_back(taken);
        const Vector x = algorithm.getParameterizationData().parametrization;
        duration = 0;
        for (int i = 0; i + 1 < points; ++i)
            duration += 2 * (grid[i + 1] - grid[i]) / (std::sqrt(std::max(x[i], 0.0)) + std::sqrt(std::max(x[i + 1], 0.0)));
    }
    std::nth_element(times.begin(), times.begin() + times.size() / 2, times.end());
    std::printf("%.9e %.12e\n", times[times.size() / 2], duration);
}
