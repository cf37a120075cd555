/* SPDX-License-Identifier: MIT
 *
 * The fastest timing of given rows by toppra's C++ core (Seidel, interpolation scheme), for one_arm_timing.py, which
 * compiles this where toppra is installed and calls it in its own process, in turn with the others. */
#include <algorithm>
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

struct Question {
    Vector grid;
    std::shared_ptr<GivenRows> constraint;
    std::shared_ptr<toppra::PiecewisePolyPath> path;
};

static Vector taken(const double *values, int size) { return Eigen::Map<const Vector>(values, size); }

/* What lasts longer than one call; never freed, the process ends with its table. a, b, c: points times rows. */
extern "C" void *toppra_question(int points, int rows, const double *grid, const double *lower, const double *upper,
                                 const double *a, const double *b, const double *c) {
    auto *question = new Question{taken(grid, points), std::make_shared<GivenRows>(rows), nullptr};
    question->constraint->lower = taken(lower, rows);
    question->constraint->upper = taken(upper, rows);
    for (int i = 0; i < points; ++i) {
        question->constraint->of_u.push_back(taken(a + i * rows, rows));
        question->constraint->of_x.push_back(taken(b + i * rows, rows));
        question->constraint->rest.push_back(taken(c + i * rows, rows));
    }
    Matrix line(2, 1);
    line << 1.0, 0.0;
    const std::vector<double> ends = {grid[0], grid[points - 1]};
    question->path = std::make_shared<toppra::PiecewisePolyPath>(Matrices{line}, ends);
    return question;
}

/* The speeds squared at the points; 0 if it found them. */
extern "C" int toppra_answer(const void *given, double *x) {
    const Question &question = *static_cast<const Question *>(given);
    toppra::algorithm::TOPPRA algorithm({question.constraint}, question.path);
    algorithm.setGridpoints(question.grid);
    algorithm.solver(std::make_shared<toppra::solver::Seidel>());
    if (algorithm.computePathParametrization(0, 0) != toppra::ReturnCode::OK) return 1;
    const Vector found = algorithm.getParameterizationData().parametrization;
    std::copy(found.data(), found.data() + found.size(), x);
    return 0;
}
