// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/gains/instances.h"

#include <algorithm>
#include <cmath>
#include <istream>
#include <map>

#include "host_tests/lab/input_error.h"
#include "host_tests/lab/json_file.h"

namespace m100::lab::gains {
namespace {

/// One line of the file. A function that cannot read its key throws InputError with the name of the key.
class Record {
 public:
  Record(const std::string& text, std::string file, long line) : file_(std::move(file)), line_(line) {
    json_ = Json::parse(text);
    if (!json_.is_object()) {
      fail("", "not a JSON object");
    }
  }

  [[noreturn]] void fail(const std::string& key, const std::string& what) const {
    throw InputError(file_, line_, key, what);
  }
  bool has(const std::string& key) const { return json_.contains(key); }
  const Json& at(const std::string& key) const {
    if (!has(key)) {
      fail(key, "missing");
    }
    return json_.at(key);
  }
  std::string text(const std::string& key) const {
    if (!at(key).is_string()) {
      fail(key, "must be a string");
    }
    return at(key).get<std::string>();
  }
  double number(const std::string& key) const { return number(key, at(key)); }
  std::vector<double> numbers(const std::string& key, std::size_t count) const { return numbers(key, at(key), count); }
  /// Fills `to` from an array of its size or from a single number. @returns whether it was a single number.
  template <typename Array>
  bool fill(const std::string& key, Array& to) const {
    if (at(key).is_number()) {
      to.fill(number(key));
      return true;
    }
    const std::vector<double> values = numbers(key, to.size());
    std::copy(values.begin(), values.end(), to.begin());
    return false;
  }
  Matrix matrix(const std::string& key, Eigen::Index rows, Eigen::Index cols) const {
    const Json& json = at(key);
    if (!json.is_array() || json.size() != static_cast<std::size_t>(rows)) {
      fail(key, "must have " + std::to_string(rows) + " rows");
    }
    Matrix out(rows, cols);
    for (Eigen::Index row = 0; row < rows; ++row) {
      const std::vector<double> values =
          numbers(key, json.at(static_cast<std::size_t>(row)), static_cast<std::size_t>(cols));
      for (Eigen::Index col = 0; col < cols; ++col) {
        out(row, col) = values.at(static_cast<std::size_t>(col));
      }
    }
    return out;
  }
  Vector vector(const std::string& key, Eigen::Index rows) const {
    const std::vector<double> values = numbers(key, static_cast<std::size_t>(rows));
    Vector out(rows);
    for (Eigen::Index row = 0; row < rows; ++row) {
      out(row) = values.at(static_cast<std::size_t>(row));
    }
    return out;
  }

 private:
  double number(const std::string& key, const Json& json) const {
    if (!json.is_number() || !std::isfinite(json.get<double>())) {
      fail(key, "must be a finite number");
    }
    return json.get<double>();
  }
  std::vector<double> numbers(const std::string& key, const Json& json, std::size_t count) const {
    if (!json.is_array() || json.size() != count) {
      fail(key, "must be " + std::to_string(count) + " numbers");
    }
    std::vector<double> out;
    for (const Json& value : json) {
      out.push_back(number(key, value));
    }
    return out;
  }

  Json json_;
  std::string file_;
  long line_;
};

constexpr double kShortestStep_s = 1e-4;  // with less, nothing moves within the horizon
constexpr double kLongestStep_s = 10.0;   // with more, the aircraft is not controlled

AxisQp read_model(const Record& record) {
  const double states = record.number("nx");  // 1e300 is not an index
  if (states != 3.0 && states != 4.0) {
    record.fail("nx", "must be 3 or 4");
  }
  const auto n = static_cast<Eigen::Index>(states);
  if (record.number("N") != static_cast<double>(mpc::kHorizon)) {
    record.fail("N", "must be " + std::to_string(mpc::kHorizon));
  }
  AxisQp out;
  out.step = {.a = record.matrix("A", n, n), .b = record.vector("B", n), .bd = record.vector("Bd", n)};
  out.q = record.vector("Q", n);
  out.r = Real(record.number("R"));
  out.rd = Real(record.number("Rd"));
  out.p = record.matrix("P", n, n);
  out.u_min = Real(record.number("u_min"));
  out.u_max = Real(record.number("u_max"));
  out.input_gain = record.has("input_gain") ? record.number("input_gain") : 1.0;
  out.tilt_sign = record.has("tilt_sign") ? record.number("tilt_sign") : 1.0;
  out.acceleration_per_tilt = model::kGravity_m_s2;
  out.drag_per_s = 0.01;
  if (!(out.r > 0)) {
    record.fail("R", "must be positive");
  }
  if (out.rd < 0) {
    record.fail("Rd", "must not be negative");
  }
  if ((out.q.array() < 0).any()) {
    record.fail("Q", "must not be negative");
  }
  if (const double dt_s = record.number("dt"); !(dt_s >= kShortestStep_s && dt_s <= kLongestStep_s)) {
    record.fail("dt", "must be from 0.0001 to 10 s");
  }
  if (!(out.u_min < out.u_max)) {
    record.fail("u_min", "must be below u_max");
  }
  if (out.step.a(0, 0) != 1 || out.step.a.col(0).tail(n - 1).cwiseAbs().maxCoeff() != 0) {
    record.fail("A", "the first state must be the position: nothing else may depend on it");
  }
  return out;
}

constexpr double kLargestId = 2147483647.0;  // fits in a long of 32 bits

Instance read_problem(const Record& record, const AxisQp& model) {
  Instance out;
  mpc::Problem<double>& problem = out.problem;
  const double id = record.number("id");
  if (id != std::floor(id) || std::abs(id) > kLargestId) {
    record.fail("id", "must be a whole number");
  }
  out.id = static_cast<long>(id);
  out.tag = record.has("tag") ? record.text("tag") : "";
  const std::vector<double> x0 = record.numbers("x0", static_cast<std::size_t>(model.step.a.rows()));
  std::copy(x0.begin(), x0.end(), problem.state.begin());
  problem.previous_input_slope = record.number("u_prev");
  problem.disturbance_m_s2 = record.number("d");
  const bool position = record.fill("p_ref", problem.position_ref_m);
  const bool velocity = record.fill("v_ref", problem.velocity_ref_m_s);
  const bool tilt = record.fill("th_ref", problem.tilt_ref_slope);
  const bool input = record.fill("u_ref", problem.input_ref_slope);
  problem.constant_targets = tilt && input;
  problem.constant_reference = position && velocity && tilt && input && problem.velocity_ref_m_s[0] == 0.0;
  if (record.has("u")) {
    out.optimum = record.numbers("u", mpc::kHorizon);
  }
  out.active = record.has("act") ? record.text("act") : "";
  out.margin = record.has("margin") ? record.number("margin") : 0.0;
  return out;
}

}  // namespace

InstanceFile read_instances(std::istream& lines, const std::string& name) {
  InstanceFile out;
  std::map<std::string, std::size_t> known;
  std::string text;
  for (long line = 1; std::getline(lines, text); ++line) {
    if (text.find_first_not_of(" \t\r") == std::string::npos) {
      continue;
    }
    const Record record(text, name, line);
    const std::string type = record.text("type");
    if (type == "model") {
      known[record.text("name")] = out.models.size();
      out.names.push_back(record.text("name"));
      out.models.push_back(read_model(record));
    } else if (type == "qp") {
      const auto model = known.find(record.text("model"));
      if (model == known.end()) {
        record.fail("model", "no model record of this name precedes this line");
      }
      out.instances.push_back(read_problem(record, out.models.at(model->second)));
      out.instances.back().model = model->second;
    } else {
      record.fail("type", "must be model or qp");
    }
  }
  if (out.instances.empty()) {
    throw InputError(name, 0, "", "holds no problem");
  }
  return out;
}

mpc::Problem<float> to_float(const mpc::Problem<double>& problem) {
  mpc::Problem<float> out;
  const double origin_m = problem.position_ref_m.back();
  for (std::size_t i = 0; i < mpc::kMaxStates; ++i) {
    out.state.at(i) = static_cast<float>(problem.state.at(i) - (i == 0 ? origin_m : 0.0));
  }
  out.previous_input_slope = static_cast<float>(problem.previous_input_slope);
  out.disturbance_m_s2 = static_cast<float>(problem.disturbance_m_s2);
  out.input_offset_slope = static_cast<float>(problem.input_offset_slope);
  for (std::size_t i = 0; i < mpc::kHorizon; ++i) {
    out.position_ref_m.at(i) = static_cast<float>(problem.position_ref_m.at(i) - origin_m);
    out.velocity_ref_m_s.at(i) = static_cast<float>(problem.velocity_ref_m_s.at(i));
    out.tilt_ref_slope.at(i) = static_cast<float>(problem.tilt_ref_slope.at(i));
    out.input_ref_slope.at(i) = static_cast<float>(problem.input_ref_slope.at(i));
  }
  out.constant_targets = problem.constant_targets;
  out.constant_reference = problem.constant_reference;
  return out;
}

}  // namespace m100::lab::gains
