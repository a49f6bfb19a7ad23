// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/gains/certificate/certificate_file.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "firmware/core/sha256.h"

namespace m100::lab::gains {
namespace {

constexpr const char* kMethod =
    "Taylor models with outward rounding over gain, frequency, damping, delay and all frequencies of the linear "
    "loop as flown, the controller as exact polynomials. In each tick of delay the zeros of one loop are counted by "
    "its turns round 0 on the unit circle; every cell keeps away from -1, so none crosses the circle. Below 0.3 rad/s, "
    "z = 1 included, 1/L is bounded. At any pose age: the same with a pose that arrives in whole ticks of 10 ms, up to "
    "20 "
    "ms earlier or later than assumed.";
constexpr const char* kNotCovered =
    "Not covered: saturation and the other affine regions of the law, re-planned references, jitter of sampling and of "
    "the poses' age, the dead zone's remainder, axes at large angles. These were flown in simulation (m100-lab "
    "campaign).";

std::string hex_of(const core::Sha256Digest& digest) {
  const auto digits = core::hex(digest);
  return {digits.begin(), digits.end()};
}

std::string sha256_of(const std::string& bytes) { return hex_of(core::sha256(std::as_bytes(std::span(bytes)))); }

nlohmann::json rows(const Eigen::MatrixXd& matrix) {
  nlohmann::json out = nlohmann::json::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    const Eigen::VectorXd row = matrix.row(i);
    out.push_back(std::vector<double>(row.data(), row.data() + row.size()));
  }
  return out;
}

nlohmann::json numbers(const Eigen::VectorXd& of) { return std::vector<double>(of.data(), of.data() + of.size()); }

/// The controllers that the proof is about, for an independent check.
nlohmann::json controllers(const model::Vehicle& vehicle) {
  nlohmann::json out;
  for (const auto& [name, axis] : {std::pair{"x", Axis::kX}, {"y", Axis::kY}}) {
    for (const auto& [channel, timing] : {std::pair{" virtual_rc", kVirtualRcTiming}, {" movement", kMovementTiming}}) {
      const FlownController controller(vehicle, axis, timing);
      const LiftedSystem& lifted = *controller.lifted;
      out[std::string(name) + channel] = {{"a", rows(lifted.a)},
                                          {"b", rows(lifted.b)},
                                          {"c", numbers(lifted.c.row(0))},
                                          {"d", numbers(lifted.d.row(0))},
                                          {"command_ticks", timing.command_ticks},
                                          {"scale_rad_per_count", controller.scale_per_count}};
    }
  }
  return out;
}

nlohmann::json pair(const Range& range) { return {range.low, range.high}; }

}  // namespace

std::string certificate_text(const companion::VehicleFile& file, companion::Mode mode, const std::string& table,
                             const std::vector<CertifiedLoop>& loops, double margin) {
  nlohmann::json list = nlohmann::json::array();
  CertifiedLoop::Peak peak, at_any_age;
  for (const CertifiedLoop& one : loops) {
    peak = {std::max(peak.bound, one.peak.bound), std::max(peak.sampled, one.peak.sampled)};
    at_any_age = {std::max(at_any_age.bound, one.at_any_age.bound),
                  std::max(at_any_age.sampled, one.at_any_age.sampled)};
    list.push_back({{"structure", one.structure},
                    {"axis", one.axis == Axis::kX ? "x" : "y"},
                    {"channel", one.by_sticks ? "virtual_rc" : "movement"},
                    {"gain", pair(one.box.gain)},
                    {"frequency", pair(one.box.frequency)},
                    {"damping", pair(one.box.damping)},
                    {"delay_s", pair(one.box.delay_s)},
                    {"bound", one.peak.bound},
                    {"sampled", one.peak.sampled},
                    {"bound_at_any_pose_age", one.at_any_age.bound},
                    {"low_rad_s", one.low_rad_s},
                    {"low_bound", one.low_bound},
                    {"cells", one.cells}});
  }
  const nlohmann::json body{{"vehicle_sha256", hex_of(file.digest)},
                            {"table_sha256", table.empty() ? "" : sha256_of(table)},
                            {"mode", companion::name(mode)},
                            {"peak_sensitivity_bound", peak.bound},
                            {"largest_sampled", peak.sampled},
                            {"bound_at_any_pose_age", at_any_age.bound},
                            {"sampled_at_any_pose_age", at_any_age.sampled},
                            {"allowed_ratio", margin},
                            {"loops", list},
                            {"controllers", controllers(companion::in_mode(file.vehicle, mode))},
                            {"method", kMethod},
                            {"not_covered", kNotCovered}};
  const nlohmann::json all{{"certificate", body}, {"sha256", sha256_of(body.dump())}};
  return all.dump(1) + "\n";
}

}  // namespace m100::lab::gains
