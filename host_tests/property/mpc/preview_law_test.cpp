// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "firmware/mpc/horizontal_mpc.h"
#include "host_tests/lab/gains/gain_tables.h"
#include "host_tests/lab/gains/instances.h"

namespace m100::lab::gains {
namespace {

using mpc::kHorizon;

/// Solves min 1/2 u'Hu + f'u, low <= u <= high by projected Newton with an exact search along the first segment of the
/// projected arc, and a projected gradient step if it stalls. Slow and simple; shares only H with the firmware.
class Reference {
 public:
  explicit Reference(const AxisQp& problem) : problem_(problem), condensed_(condense(problem)) {}

  Vector gradient_at_zero(const mpc::Problem<double>& p) const {
    const Eigen::Index n = problem_.step.a.rows();
    Vector x0(n);
    Vector r = Vector::Zero(static_cast<Eigen::Index>(kHorizon) * n);
    Vector s(static_cast<Eigen::Index>(kHorizon));
    for (Eigen::Index i = 0; i < n; ++i) {
      x0(i) = p.state.at(static_cast<std::size_t>(i));
    }
    for (std::size_t k = 0; k < kHorizon; ++k) {
      const Eigen::Index row = static_cast<Eigen::Index>(k) * n;
      r(row) = p.position_ref_m.at(k);
      r(row + 1) = p.velocity_ref_m_s.at(k);
      r(row + 2) = p.tilt_ref_slope.at(k);
      s(static_cast<Eigen::Index>(k)) = p.input_ref_slope.at(k) + p.input_offset_slope;
    }
    Vector f =
        condensed_.weighted * (condensed_.tx * x0 + condensed_.td * Real(p.disturbance_m_s2) - r) - problem_.r * s;
    f(0) -= problem_.rd * (Real(p.previous_input_slope) + Real(p.input_offset_slope));
    return f;
  }

  /// @returns u, which is input_slope in the firmware.
  Vector solve_qp(const mpc::Problem<double>& p) const {
    const Vector f = gradient_at_zero(p);
    const Matrix& h = condensed_.h;
    const Real low = problem_.u_min + Real(p.input_offset_slope);
    const Real high = problem_.u_max + Real(p.input_offset_slope);
    const auto clip = [&](const Vector& u) -> Vector { return u.cwiseMax(low).cwiseMin(high); };
    const auto cost = [&](const Vector& u) -> Real { return Real(0.5) * u.dot(h * u) + f.dot(u); };
    Vector u = clip(solve(h, -f));
    const Real curvature = h.cwiseAbs().rowwise().sum().maxCoeff();
    for (int iteration = 0; iteration < 2000; ++iteration) {
      const Vector g = h * u + f;
      if ((u - clip(u - g / curvature)).cwiseAbs().maxCoeff() < Real(1e-18)) {
        break;
      }
      const Vector d = newton_step(h, g, free_inputs(u, g, low, high));
      Vector best = clip(u - g / curvature);
      for (Real step = 1; step > Real(1e-6); step /= 2) {
        const Vector tried = clip(u + step * d);
        if (cost(tried) < cost(best)) {
          best = tried;
          break;
        }
      }
      u = best;
    }
    return u.array() - Real(p.input_offset_slope);
  }

 private:
  /// The inputs that are at no limit, or would leave it.
  static std::vector<Eigen::Index> free_inputs(const Vector& u, const Vector& g, Real low, Real high) {
    std::vector<Eigen::Index> free;
    for (Eigen::Index i = 0; i < u.size(); ++i) {
      if (!((u(i) <= low && g(i) > 0) || (u(i) >= high && g(i) < 0))) {
        free.push_back(i);
      }
    }
    return free;
  }
  /// Newton step of the free inputs; the others stay.
  static Vector newton_step(const Matrix& h, const Vector& g, const std::vector<Eigen::Index>& free) {
    const auto m = static_cast<Eigen::Index>(free.size());
    Matrix hf(m, m);
    Vector gf(m);
    for (Eigen::Index i = 0; i < m; ++i) {
      gf(i) = g(free.at(static_cast<std::size_t>(i)));
      for (Eigen::Index j = 0; j < m; ++j) {
        hf(i, j) = h(free.at(static_cast<std::size_t>(i)), free.at(static_cast<std::size_t>(j)));
      }
    }
    const Vector df = m > 0 ? Vector(solve(hf, -gf)) : Vector();
    Vector d = Vector::Zero(g.size());
    for (Eigen::Index i = 0; i < m; ++i) {
      d(free.at(static_cast<std::size_t>(i))) = df(i);
    }
    return d;
  }

  AxisQp problem_;
  Condensed condensed_;
};

AxisQp random_model(std::mt19937& random) {
  const auto between = [&random](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  model::Vehicle vehicle;
  const bool first = random() % 2 == 0;
  for (model::StickAxis* axis : {&vehicle.pitch, &vehicle.roll}) {
    axis->time_constant_s = first ? between(0.05, 0.6) : 0.0;
    axis->natural_frequency_rad_s = first ? 0.0 : between(4.0, 20.0);
    axis->damping_ratio = first ? 0.0 : between(0.3, 1.5);
    axis->lead_zero_s = random() % 3 == 0 ? between(0.0, 0.03) : 0.0;
  }
  vehicle.translation.linear_drag_per_s = between(0.0, 0.5);
  vehicle.translation.tilt_limit_rad = between(0.1, 0.6);
  vehicle.mpc.input = std::exp(between(0.0, 5.0));
  vehicle.mpc.input_rate = between(0.0, 5.0);
  vehicle.mpc.tilt = between(0.0, 40.0);
  AxisQp out = axis_qp(vehicle, random() % 2 == 0 ? Axis::kX : Axis::kY);
  if (random() % 3 == 0) {
    out.u_min *= Real(0.5);  // asymmetric limits
  }
  return out;
}

mpc::Problem<double> random_problem(std::mt19937& random) {
  std::normal_distribution<double> normal;
  mpc::Problem<double> p;
  const double size = std::pow(10.0, std::uniform_real_distribution<double>(-1.5, 1.0)(random));
  p.state = {5.0 + size * normal(random), size * normal(random), 0.2 * normal(random), 0.5 * normal(random)};
  p.previous_input_slope = 0.2 * normal(random);
  p.disturbance_m_s2 = normal(random);
  p.input_offset_slope = random() % 2 == 0 ? 0.05 * normal(random) : 0.0;
  p.position_ref_m.fill(5.0);
  const double w = 6.0 * std::uniform_real_distribution<double>(0.0, 1.0)(random);
  if (random() % 4 != 0) {
    for (std::size_t k = 0; k < kHorizon; ++k) {
      const double t = 0.1 * static_cast<double>(k);
      p.position_ref_m.at(k) += 0.3 * size * std::sin(w * t);
      p.velocity_ref_m_s.at(k) = 0.3 * size * w * std::cos(w * t);
    }
  }
  p.constant_targets = random() % 2 == 0;
  p.tilt_ref_slope.fill(0.05 * normal(random));
  p.input_ref_slope.fill(0.05 * normal(random));
  if (!p.constant_targets) {
    for (std::size_t k = 0; k < kHorizon; ++k) {
      p.tilt_ref_slope.at(k) = 0.2 * normal(random);
      p.input_ref_slope.at(k) = 0.2 * normal(random);
    }
  }
  return p;
}

class PreviewLaw : public ::testing::TestWithParam<unsigned> {};

// Catches any wrong table entry, tap, sign, limit or step of the iteration, for random models.
TEST_P(PreviewLaw, IsTheOptimumOfAnIndependentSolver) {
  std::mt19937 random(GetParam());
  for (int m = 0; m < 4; ++m) {
    const AxisQp model = random_model(random);
    const Reference reference(model);
    const mpc::GainTable<double> table = make_gain_table(model);
    const mpc::GainTable<float> table_f = to_float(table);
    mpc::HorizontalMpc<double> controller(table);
    mpc::HorizontalMpc<float> single(table_f);
    for (int i = 0; i < 25; ++i) {
      const mpc::Problem<double> problem = random_problem(random);
      const Vector optimum = reference.solve_qp(problem);
      const mpc::Solution<double> solution = controller.solve(problem);  // keeps the tableau of the previous problem
      EXPECT_NE(solution.path, mpc::Path::kClipped);
      EXPECT_LE(solution.changes, mpc::kMaxChanges);
      for (std::size_t k = 0; k < kHorizon; ++k) {
        ASSERT_NEAR(solution.input_slope.at(k), static_cast<double>(optimum(static_cast<Eigen::Index>(k))), 1e-9)
            << "model " << m << " problem " << i << " input " << k;
      }
      const mpc::Solution<float> in_float = single.solve(to_float(problem));
      EXPECT_NE(in_float.path, mpc::Path::kClipped);
      EXPECT_NEAR(static_cast<double>(in_float.input_slope[0]), static_cast<double>(optimum(0)), 1e-4);
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Seed, PreviewLaw, ::testing::Range(1U, 9U));

// The LQR baseline must be the optimum without limits, clipped to the limits, at every place.
TEST_P(PreviewLaw, TheBaselineIsTheOptimumWithoutLimitsClipped) {
  std::mt19937 random(1000 + GetParam());
  unsigned bound = 0;
  for (int m = 0; m < 4; ++m) {
    const AxisQp model = random_model(random);
    const mpc::GainTable<double> table = make_gain_table(model);
    AxisQp without = model;
    without.u_min = -1e6;
    without.u_max = 1e6;
    const mpc::GainTable<double> unlimited = make_gain_table(without);
    mpc::HorizontalMpc<double> baseline(table, mpc::Law::kLqr);
    mpc::HorizontalMpc<double> free(unlimited);
    for (int i = 0; i < 25; ++i) {
      const mpc::Problem<double> problem = random_problem(random);
      const mpc::Solution<double> wanted = free.solve(problem);
      const mpc::Solution<double> solution = baseline.solve(problem);
      bool cut = false;
      for (std::size_t k = 0; k < kHorizon; ++k) {
        const double kept = std::clamp(wanted.input_slope.at(k), table.input_min_slope, table.input_max_slope);
        cut = cut || kept != wanted.input_slope.at(k);
        ASSERT_NEAR(solution.input_slope.at(k), kept, 1e-12 * (1.0 + std::abs(wanted.input_slope.at(k))));
      }
      EXPECT_EQ(solution.path, cut ? mpc::Path::kClipped : mpc::Path::kTable);
      bound += cut ? 1U : 0U;
    }
  }
  EXPECT_GT(bound, 10U);  // otherwise the test shows nothing
}

// A non-finite input must give the flagged, finite answer, and must not affect the next tick.
TEST(PreviewLawFaults, ANumberThatIsNotOneGivesAFiniteClippedAnswer) {
  std::mt19937 random(3);
  const mpc::GainTable<double> table = make_gain_table(random_model(random));
  mpc::HorizontalMpc<double> controller(table);
  mpc::HorizontalMpc<double> untouched(table);
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                           -std::numeric_limits<double>::infinity(), 1e300}) {
    for (int place = 0; place < 6; ++place) {
      mpc::Problem<double> problem = random_problem(random);
      mpc::Problem<double> wrong = problem;
      double* const places[] = {&wrong.state[0],
                                &wrong.state[2],
                                &wrong.disturbance_m_s2,
                                &wrong.position_ref_m[7],
                                &wrong.velocity_ref_m_s[19],
                                &wrong.previous_input_slope};
      *places[place] = bad;
      const mpc::Solution<double> solution = controller.solve(wrong);
      for (const double input : solution.input_slope) {
        EXPECT_GE(input, table.input_min_slope - 1e-12);
        EXPECT_LE(input, table.input_max_slope + 1e-12);
      }
      if (!std::isfinite(bad)) {
        EXPECT_EQ(solution.path, mpc::Path::kClipped) << bad << " at place " << place;
      }
      const mpc::Solution<double> next = controller.solve(problem);
      EXPECT_NEAR(next.input_slope[0], untouched.solve(problem).input_slope[0], 1e-9);
    }
  }
}

TEST(PreviewLawFaults, TheSameHistoryGivesTheSameBits) {
  std::mt19937 random(5);
  const mpc::GainTable<double> table = make_gain_table(random_model(random));
  mpc::HorizontalMpc<double> first(table);
  mpc::HorizontalMpc<double> second(table);
  for (int i = 0; i < 200; ++i) {
    const mpc::Problem<double> problem = random_problem(random);
    EXPECT_EQ(first.solve(problem).input_slope, second.solve(problem).input_slope);
  }
}

}  // namespace
}  // namespace m100::lab::gains
