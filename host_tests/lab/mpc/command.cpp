// SPDX-License-Identifier: BSD-3-Clause
// m100-lab mpc solve: solves quadratic programs from a file with the controller's own solver.
#include <algorithm>
#include <cstdio>
#include <memory>
#include <sstream>
#include <vector>

#include "firmware/companion/command_line.h"
#include "firmware/companion/files/file_use.h"
#include "firmware/companion/files/text/json.h"
#include "firmware/mpc/horizontal_mpc.h"
#include "host_tests/lab/gains/gain_tables.h"
#include "host_tests/lab/gains/instances.h"
#include "host_tests/lab/gains/setpoint/setpoint_law.h"
#include "host_tests/lab/subcommands.h"
#include "host_tests/lab/whole_file.h"

namespace m100::lab {
namespace {

struct MpcOptions {
  std::string file;
  std::string scalar = "double";
  std::string law = "preview";
};

const char* name(mpc::Path path) {
  switch (path) {
    case mpc::Path::kSetpoint:
      return "setpoint";
    case mpc::Path::kTable:
      return "table";
    case mpc::Path::kActiveSet:
      return "active_set";
    case mpc::Path::kClipped:
      return "clipped";
  }
  return "unknown";
}

template <typename T>
mpc::Problem<T> problem_in(const mpc::Problem<double>& problem) {
  if constexpr (std::is_same_v<T, double>) {
    return problem;
  } else {
    return gains::to_float(problem);
  }
}

template <typename T>
void print(const gains::Instance& instance, const mpc::Solution<T>& solution) {
  const std::size_t known = solution.path == mpc::Path::kSetpoint ? 1 : mpc::kHorizon;
  const std::vector<double> inputs(solution.input_slope.begin(),
                                   solution.input_slope.begin() + static_cast<long>(known));
  const Json line{{"id", instance.id},
                  {"u", inputs},
                  {"path", name(solution.path)},
                  {"changes", solution.changes},
                  {"kkt", static_cast<double>(solution.kkt_residual)}};
  std::printf("%s\n", line.dump().c_str());
}

/// The rows of a set-point law in the scalar type T.
template <typename T>
struct Rows {
  std::vector<T> planes;
  std::vector<T> laws;
  std::vector<mpc::SetpointNode> nodes;
};

template <typename T>
void solve(const gains::InstanceFile& file, bool setpoint) {
  std::vector<mpc::GainTable<T>> tables;
  std::vector<Rows<T>> laws(file.models.size());
  for (const gains::AxisQp& model : file.models) {
    tables.push_back(gains::table_in<T>(gains::make_gain_table(model)));
    if (setpoint) {
      const gains::SetpointRows rows = gains::make_setpoint_law(model);
      Rows<T>& law = laws.at(tables.size() - 1);
      law = {.planes = {rows.planes.begin(), rows.planes.end()},
             .laws = {rows.laws.begin(), rows.laws.end()},
             .nodes = rows.nodes};
      mpc::SetpointTree<T>& tree = tables.back().setpoint;
      tree = {.nodes = law.nodes, .planes = law.planes, .laws = law.laws, .box = {}, .mirror = {}, .depth = rows.depth};
      std::copy(rows.box.begin(), rows.box.end(), tree.box.begin());
      std::copy(rows.mirror.begin(), rows.mirror.end(), tree.mirror.begin());
    }
  }
  std::vector<std::unique_ptr<mpc::HorizontalMpc<T>>> controllers;
  controllers.reserve(tables.size());
  for (const mpc::GainTable<T>& table : tables) {
    controllers.push_back(std::make_unique<mpc::HorizontalMpc<T>>(table));
  }
  for (const gains::Instance& instance : file.instances) {
    mpc::HorizontalMpc<T>& controller = *controllers.at(instance.model);
    controller.reset();  // the instances of a file are independent
    mpc::Solution<T> solution;
    if (setpoint) {
      controller.solve(problem_in<T>(instance.problem), solution);
    } else {
      controller.solve_preview(problem_in<T>(instance.problem), solution);
    }
    print(instance, solution);
  }
}

void run(const MpcOptions& options) {
  companion::FileUse().reads("FILE", options.file).check();
  std::istringstream stream(whole_file(options.file));
  const gains::InstanceFile file = gains::read_instances(stream, options.file);
  if (options.scalar == "double") {
    solve<double>(file, options.law == "setpoint");
  } else {
    solve<float>(file, options.law == "setpoint");
  }
}

}  // namespace

void add_mpc(companion::CommandLine& lab) {
  const companion::Subcommand mpc = lab.add_subcommand("mpc", "run the horizontal MPC alone");
  mpc.require_subcommand();
  const auto [command, options] =
      mpc.add_subcommand<MpcOptions>("solve", "solve quadratic programs: JSON lines in, JSON lines out", run);
  command.add_option("FILE", options->file, "model records, then problems (JSON lines)").required();
  command.add_option("--scalar", options->scalar, "arithmetic of the controller").one_of({"double", "float"});
  command
      .add_option("--law", options->law,
                  "preview: the whole input sequence; setpoint: the explicit law inside its range")
      .one_of({"preview", "setpoint"});
}

}  // namespace m100::lab
