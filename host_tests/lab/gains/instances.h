// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "firmware/mpc/problem.h"
#include "host_tests/lab/gains/axis_model.h"

namespace m100::lab::gains {

/// One quadratic program of an instance file, with its optimum if the file gives it.
struct Instance {
  long id = 0;
  std::size_t model = 0;  ///< index into InstanceFile::models
  std::string tag;
  mpc::Problem<double> problem;
  std::vector<double> optimum;  ///< empty, or 20 inputs
  std::string active;           ///< empty, or 20 characters: 0 for an input between its limits, else + or -
  double margin = 0.0;
};

struct InstanceFile {
  std::vector<AxisQp> models;
  std::vector<std::string> names;  ///< of the models
  std::vector<Instance> instances;
};

/// Reads JSON lines: model records, each before its problems, and problems. `name` is the file's name in messages.
/// Throws InputError naming file, line and key.
InstanceFile read_instances(std::istream& lines, const std::string& name);

/// A problem in float. Positions are first made relative to the end of the reference, to keep their digits.
mpc::Problem<float> to_float(const mpc::Problem<double>& problem);

}  // namespace m100::lab::gains
