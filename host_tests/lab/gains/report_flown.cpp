// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/gains/report_flown.h"

#include <algorithm>
#include <cstdio>
#include <string>

#include "firmware/core/maths.h"

namespace m100::lab::gains {
namespace {

Json to_json(const BoxPoint& of) {
  return {{"structure", of.structure},
          {"axis", of.axis == Axis::kX ? "x" : "y"},
          {"channel", of.timing.by_sticks ? "virtual_rc" : "movement"},
          {"gain", of.gain},
          {"frequency", of.frequency},
          {"damping", of.damping},
          {"delay_s", of.delay_s},
          {"pose_age_s", 0.01 * static_cast<double>(of.timing.pose_age_ticks)},
          {"at_rad_s", of.at_rad_s}};
}

Json to_json(const AxisBox& box) {
  const auto pair = [](const Range& range) { return Json{range.low, range.high}; };
  return {{"gain", pair(box.gain)},
          {"frequency", pair(box.frequency)},
          {"damping", pair(box.damping)},
          {"delay_s", pair(box.delay_s)}};
}

/// Prints and returns the worst margins over corners or box of one axis and channel, and whether they keep the limits.
Json report_worst(const WorstMargins& worst, const char* over, double max_peak, double min_delay_s) {
  const bool kept = worst.stable && worst.peak_sensitivity <= max_peak && worst.delay_margin_s >= min_delay_s;
  std::printf("  over %s: %s, %s%s\n", over, worst.peak_text().c_str(), worst.delay_text().c_str(),
              kept ? "" : ": NOT KEPT");
  return {{"stable", worst.stable},
          {"peak_sensitivity", worst.peak_sensitivity},
          {"delay_margin_s", worst.delay_margin_s},
          {"points", worst.points},
          {"worst", to_json(worst.at_peak)},
          {"kept", kept}};
}

/// Joins the box of one loop to that of all.
void add_worst(const Json& one, Json& all) {
  all["points"] = all["points"].get<std::size_t>() + one["points"].get<std::size_t>();
  all["delay_margin_s"] = std::min(all["delay_margin_s"].get<double>(), one["delay_margin_s"].get<double>());
  if (one["peak_sensitivity"].get<double>() > all["peak_sensitivity"].get<double>()) {
    all["peak_sensitivity"] = one["peak_sensitivity"];
    all["worst"] = one["worst"];
  }
}

Json rows(const Eigen::MatrixXd& matrix) {
  Json out = Json::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    const Eigen::VectorXd row = matrix.row(i);
    out.push_back(std::vector<double>(row.data(), row.data() + row.size()));
  }
  return out;
}

/// The controllers whose margins are reported, for an independent check.
Json controllers(const model::Vehicle& believed) {
  Json out;
  for (const auto& [name, axis] : {std::pair{"x", Axis::kX}, {"y", Axis::kY}}) {
    for (const auto& [channel, timing] : {std::pair{" virtual_rc", kVirtualRcTiming}, {" movement", kMovementTiming}}) {
      const FlownController controller(believed, axis, timing);
      out[std::string(name) + channel] = {
          {"a", rows(controller.lifted->a)},       {"b", rows(controller.lifted->b)},
          {"c", rows(controller.lifted->c)[0]},    {"d", rows(controller.lifted->d)[0]},
          {"command_ticks", timing.command_ticks}, {"scale_rad_per_count", controller.scale_per_count}};
    }
  }
  return out;
}

/// Reports corners and box of every structure, axis and channel into the cells of `flown`. @returns the worst of the
/// whole box
Json report_boxes(const model::Vehicle& believed, const std::vector<OpenStructure>& structures,
                  const MarginLimits& limits, Json& flown) {
  const MarginBox box(structures);
  MarginBox::Laws laws{believed};
  Json out{{"peak_sensitivity", 0.0}, {"delay_margin_s", 1e9}, {"points", 0}};
  bool kept = true;
  std::printf(
      "the box's grid: frequency, damping and delay as identified and at both ends, pose 0, 20 and 40 ms old, 201 "
      "frequencies from 0.3 rad/s; gain in closed form; refined round the worst point\n");
  for (std::size_t k = 0; k < structures.size(); ++k) {
    for (const auto& [name, axis] : {std::pair{"x", Axis::kX}, {"y", Axis::kY}}) {
      Json& cell = flown[structures[k].name][name];
      for (const auto& [channel, by_sticks] : {std::pair{"virtual_rc", true}, {"movement", false}}) {
        const BoxSelection only{.structure = k, .axis = axis, .by_sticks = by_sticks};
        const Json& corners = cell["corners"][channel] =
            report_worst(box.worst(laws, MarginBox::Extent::kCorners, only), "gain and frequency", limits.corner_peak,
                         limits.corner_delay_s);
        Json& whole = cell["box"][channel] =
            report_worst(box.worst(laws, MarginBox::Extent::kBox, only), "the whole box", limits.box_peak, 0.0);
        whole["ranges"] = to_json(structures[k].box[axis == Axis::kX ? 0 : 1]);
        kept = kept && corners["kept"].get<bool>() && whole["kept"].get<bool>();
        add_worst(whole, out);
      }
    }
  }
  if (!kept) {
    std::printf(
        "warning: as flown, not every corner keeps a peak sensitivity of %.1f and %.0f ms of delay, or the whole box "
        "one of %.1f\n"
        "To distinguish the structures, fly stick steps (m100-lab excite --kind doublet) with the gyro logged: with a "
        "lead zero the aircraft rotates in the sample of the step, with a pure delay it does not.\n",
        limits.corner_peak, limits.corner_delay_s * 1e3, limits.box_peak);
  }
  return out;
}

Json report_flown_axis(const model::Vehicle& believed, const OpenStructure& structure, const char* name, Axis axis) {
  Json out;
  for (const auto& [channel, timing] : {std::pair{"virtual_rc", &kVirtualRcTiming}, {"movement", &kMovementTiming}}) {
    const Margins margins = flown_margins_of(believed, structure.vehicle, axis, *timing);
    std::printf(
        "%s as flown on %s, %s: %s, peak sensitivity %.2f, gain margin %.2f, phase margin %.0f deg, delay margin %.0f "
        "ms\n",
        name, structure.name.c_str(), words(*timing).c_str(), margins.stable ? "stable" : "UNSTABLE",
        margins.peak_sensitivity, margins.gain_margin, margins.phase_margin_rad * 180.0 / core::kPi,
        margins.delay_margin_s * 1e3);
    out[channel] = margins_json(margins);
  }
  return out;
}

}  // namespace

Json margins_json(const Margins& margins) {
  return {{"stable", margins.stable},
          {"peak_sensitivity", margins.peak_sensitivity},
          {"gain_margin", margins.gain_margin},
          {"phase_margin_rad", margins.phase_margin_rad},
          {"delay_margin_s", margins.delay_margin_s},
          {"crossover_rad_s", margins.crossover_rad_s},
          {"robust", is_robust(margins)}};
}

Json report_flown(const model::Vehicle& believed, const std::vector<OpenStructure>& structures,
                  const MarginLimits* limits) {
  Json out;
  for (const OpenStructure& structure : structures) {
    for (const auto& [name, axis] : {std::pair{"x", Axis::kX}, {"y", Axis::kY}}) {
      out["flown"][structure.name][name] = report_flown_axis(believed, structure, name, axis);
    }
  }
  if (limits != nullptr) {
    out["box"] = report_boxes(believed, structures, *limits, out["flown"]);
    out["controllers"] = controllers(believed);
  }
  return out;
}

}  // namespace m100::lab::gains
