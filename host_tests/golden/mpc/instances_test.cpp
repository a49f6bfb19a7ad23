// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "firmware/mpc/horizontal_mpc.h"
#include "host_tests/lab/gains/gain_tables.h"
#include "host_tests/lab/gains/instances.h"
#include "host_tests/shared_files.h"

namespace m100::lab::gains {
namespace {

constexpr std::size_t kInstances = 4000;
constexpr std::size_t kSample = 300;  ///< every thirteenth or so of them, in golden/vectors

// The file holds 4000 instances, solved to 1e-12 by two independent programs (projected Newton in 80 bits; active-set
// re-solve).
struct Worst {
  double first_rad = 0.0;
  double any_rad = 0.0;
  double kkt = 0.0;
  unsigned changes = 0;
  unsigned wrong_active = 0;
  unsigned clipped = 0;
};

template <typename T>
mpc::Problem<T> problem_in(const mpc::Problem<double>& problem) {
  if constexpr (std::is_same_v<T, double>) {
    return problem;
  } else {
    return to_float(problem);
  }
}

/// Solves all instances. @param warm keeps the tableau from one instance to the next.
template <typename T>
Worst solve_all(const InstanceFile& file, bool warm) {
  std::vector<mpc::GainTable<T>> tables;
  std::vector<std::unique_ptr<mpc::HorizontalMpc<T>>> controllers;
  tables.reserve(file.models.size());
  for (const AxisQp& model : file.models) {
    tables.push_back(table_in<T>(make_gain_table(model)));
    controllers.push_back(std::make_unique<mpc::HorizontalMpc<T>>(tables.back()));
  }
  Worst worst;
  for (const Instance& instance : file.instances) {
    mpc::HorizontalMpc<T>& controller = *controllers.at(instance.model);
    if (!warm) {
      controller.reset();
    }
    mpc::Solution<T> solution;
    controller.solve_preview(problem_in<T>(instance.problem), solution);
    for (std::size_t i = 0; i < mpc::kHorizon; ++i) {
      const double error = std::abs(static_cast<double>(solution.input_slope.at(i)) - instance.optimum.at(i));
      worst.any_rad = std::max(worst.any_rad, error);
      worst.first_rad = i == 0 ? std::max(worst.first_rad, error) : worst.first_rad;
      const bool at_limit =
          std::abs(std::abs(solution.input_slope.at(i)) - tables.at(instance.model).input_max_slope) <= 0;
      worst.wrong_active += instance.margin > 1e-3 && at_limit != (instance.active.at(i) != '0') ? 1U : 0U;
    }
    worst.kkt = std::max(worst.kkt, static_cast<double>(solution.kkt_residual));
    worst.changes = std::max<unsigned>(worst.changes, solution.changes);
    worst.clipped += solution.path == mpc::Path::kClipped ? 1U : 0U;
  }
  return worst;
}

class MpcInstances : public ::testing::TestWithParam<bool> {
 protected:
  /// The figures of a page: errors in rad, and changes of the active set.
  void record(const std::string& scalar, const Worst& worst) {
    const std::string start = GetParam() ? "kept." : "cold.";
    RecordProperty("figure.instances." + start + scalar + ".first", in_rad(worst.first_rad));
    RecordProperty("figure.instances." + start + scalar + ".sequence", in_rad(worst.any_rad));
    RecordProperty("figure.instances." + start + scalar + ".changes", std::to_string(worst.changes));
  }

 private:
  static std::string in_rad(double error_rad) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.1e rad", error_rad);
    return text.data();
  }
};

TEST_P(MpcInstances, WholeSequenceInDouble) {
  M100_SHARED_FILE_OR_SKIP(path, "mpc/instances_dev.jsonl");
  std::ifstream stream(path);
  const InstanceFile file = read_instances(stream, path.string());
  ASSERT_TRUE(file.instances.size() == kInstances || file.instances.size() == kSample) << file.instances.size();
  const Worst worst = solve_all<double>(file, GetParam());
  if (file.instances.size() == kInstances) {
    record("double", worst);
  }
  EXPECT_LE(worst.any_rad, 1e-9);
  EXPECT_LE(worst.kkt, 2e-8);
  EXPECT_LE(worst.changes, mpc::kMaxChanges);
  EXPECT_EQ(worst.wrong_active, 0U);
  EXPECT_EQ(worst.clipped, 0U);
}

TEST_P(MpcInstances, FirstInputInFloat) {
  M100_SHARED_FILE_OR_SKIP(path, "mpc/instances_dev.jsonl");
  std::ifstream stream(path);
  const InstanceFile file = read_instances(stream, path.string());
  const Worst worst = solve_all<float>(file, GetParam());
  if (file.instances.size() == kInstances) {
    record("float", worst);
  }
  EXPECT_LE(worst.first_rad, 2e-5);
  EXPECT_LE(worst.changes, mpc::kMaxChanges);
  EXPECT_EQ(worst.wrong_active, 0U);
  EXPECT_EQ(worst.clipped, 0U);
}

INSTANTIATE_TEST_SUITE_P(Start, MpcInstances, ::testing::Values(false, true),
                         [](const auto& tested) { return tested.param ? "Kept" : "Cold"; });

// Our tables are made from the continuous models; the file holds an independent discretisation and Riccati solution.
TEST(MpcModels, AreTheExactDiscretisationsOfTheAttitudeModels) {
  M100_SHARED_FILE_OR_SKIP(path, "mpc/instances_dev.jsonl");
  std::ifstream stream(path);
  const InstanceFile file = read_instances(stream, path.string());
  for (std::size_t i = 0; i < file.models.size(); ++i) {
    if (file.names.at(i).rfind("ident", 0) != 0) {
      continue;  // the vehicle file has no static gain other than 1
    }
    model::Vehicle vehicle;
    if (file.names.at(i) == "ident_first_order") {
      vehicle.pitch.time_constant_s = 0.087;
    } else {
      vehicle.pitch.natural_frequency_rad_s = 9.36;
      vehicle.pitch.damping_ratio = 0.68;
    }
    vehicle.mpc = {.position = 40, .velocity = 20, .tilt = 20, .input = 35, .input_rate = 0.3};
    const AxisQp& theirs = file.models.at(i);
    vehicle.translation.tilt_limit_rad = std::atan(static_cast<double>(theirs.u_max));
    const AxisQp ours = axis_qp(vehicle, Axis::kX);
    EXPECT_LE(static_cast<double>((ours.step.a - theirs.step.a).cwiseAbs().maxCoeff()), 1e-14);
    EXPECT_LE(static_cast<double>((ours.step.b - theirs.step.b).cwiseAbs().maxCoeff()), 1e-14);
    EXPECT_LE(static_cast<double>((ours.step.bd - theirs.step.bd).cwiseAbs().maxCoeff()), 1e-14);
    EXPECT_LE(static_cast<double>((ours.p - theirs.p).cwiseAbs().maxCoeff()), 1e-10);
    EXPECT_NEAR(static_cast<double>(ours.u_max), static_cast<double>(theirs.u_max), 1e-15);
  }
}

}  // namespace
}  // namespace m100::lab::gains
