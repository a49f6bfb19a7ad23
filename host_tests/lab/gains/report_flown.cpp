// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/gains/report_flown.h"

#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace m100::lab::gains {
namespace {

/// Factors on gain and frequency: both are known to within a fifth.
constexpr std::array<double, 3> kCorners{1.0, 0.8, 1.2};

model::Vehicle corner(model::Vehicle vehicle, double gain, double frequency) {
  for (model::StickAxis* axis : {&vehicle.roll, &vehicle.pitch}) {
    axis->scale_per_count *= gain;
    axis->natural_frequency_rad_s *= frequency;
    axis->time_constant_s /= frequency;
  }
  return vehicle;
}

/// The worst value of each margin over the corners, and its corner (gain, frequency).
struct WorstCorner {
  Margins margins{.stable = true, .delay_margin_s = kLargestDelay_s};
  std::array<double, 2> most_sensitive{1.0, 1.0};
  std::array<double, 2> min_delay{1.0, 1.0};
};

WorstCorner worst_corner(const model::Vehicle& believed, const Structure& structure, Axis axis) {
  WorstCorner out;
  Margins& worst = out.margins;
  for (const double gain : kCorners) {
    for (const double frequency : kCorners) {
      const Margins margins =
          flown_margins_of(believed, corner(structure.vehicle, gain, frequency), axis, kVirtualRcTiming);
      worst.stable = worst.stable && margins.stable;
      if (margins.peak_sensitivity > worst.peak_sensitivity) {
        worst.peak_sensitivity = margins.peak_sensitivity;
        out.most_sensitive = {gain, frequency};
      }
      if (margins.delay_margin_s < worst.delay_margin_s) {
        worst.delay_margin_s = margins.delay_margin_s;
        out.min_delay = {gain, frequency};
      }
    }
  }
  return out;
}

nlohmann::json report_flown_axis(const model::Vehicle& believed, const Structure& structure, const char* name,
                                 Axis axis, bool corners) {
  nlohmann::json out;
  for (const auto& [channel, timing] : {std::pair{"virtual_rc", &kVirtualRcTiming}, {"movement", &kMovementTiming}}) {
    const Margins margins = flown_margins_of(believed, structure.vehicle, axis, *timing);
    std::printf("as flown on %s, %s, %s: %s, peak sensitivity %.2f, gain margin %.2f, delay margin %.0f ms\n",
                structure.name.c_str(), channel, name, margins.stable ? "stable" : "UNSTABLE", margins.peak_sensitivity,
                margins.gain_margin, margins.delay_margin_s * 1e3);
    out[channel] = margins_json(margins);
  }
  if (!corners) {
    return out;
  }
  const auto [worst, most_sensitive, min_delay] = worst_corner(believed, structure, axis);
  const bool kept =
      worst.stable && worst.peak_sensitivity <= kLargestPeakSensitivity && worst.delay_margin_s >= kFieldDelayMargin_s;
  std::printf(
      "  over gain and frequency +-20 %%, virtual_rc, %s: %speak sensitivity %.2f (gain x %.1f, frequency x %.1f), "
      "delay margin %.0f ms (gain x %.1f, frequency x %.1f)%s\n",
      name, worst.stable ? "" : "UNSTABLE in a corner, ", worst.peak_sensitivity, most_sensitive[0], most_sensitive[1],
      worst.delay_margin_s * 1e3, min_delay[0], min_delay[1], kept ? "" : ": NOT KEPT");
  out["corners"] = {{"stable", worst.stable},
                    {"peak_sensitivity", worst.peak_sensitivity},
                    {"delay_margin_s", worst.delay_margin_s},
                    {"kept", kept}};
  return out;
}

}  // namespace

nlohmann::json margins_json(const Margins& margins) {
  return {{"stable", margins.stable},
          {"peak_sensitivity", margins.peak_sensitivity},
          {"gain_margin", margins.gain_margin},
          {"phase_margin_rad", margins.phase_margin_rad},
          {"delay_margin_s", margins.delay_margin_s},
          {"crossover_rad_s", margins.crossover_rad_s},
          {"robust", is_robust(margins)}};
}

nlohmann::json report_flown(const model::Vehicle& believed, const std::vector<Structure>& structures, bool corners) {
  nlohmann::json out;
  bool kept = true;
  for (const Structure& structure : structures) {
    for (const auto& [name, axis] : {std::pair{"x", Axis::kX}, {"y", Axis::kY}}) {
      nlohmann::json& cell = out[structure.name][name] = report_flown_axis(believed, structure, name, axis, corners);
      kept = kept && (!corners || cell["corners"]["kept"].get<bool>());
    }
  }
  if (!kept) {
    std::printf(
        "warning: as flown, not every corner keeps a peak sensitivity of %.1f and %.0f ms of delay\n"
        "To distinguish the structures, fly stick steps (m100-lab excite --kind doublet) with the gyro logged: with a "
        "lead zero the aircraft rotates in the sample of the step, with a pure delay it does not.\n",
        kLargestPeakSensitivity, kFieldDelayMargin_s * 1e3);
  }
  return out;
}

}  // namespace m100::lab::gains
