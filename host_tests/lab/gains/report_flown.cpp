// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/gains/report_flown.h"

#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>

#include "firmware/core/maths.h"

namespace m100::lab::gains {
namespace {

/// Prints and returns the worst margins over corners or box of one axis and channel, and whether they keep the limits.
nlohmann::json report_worst(const WorstMargins& worst, const char* over, const char* channel, const char* name,
                            const MarginLimits& limits, bool with_delay) {
  const bool kept = worst.stable && worst.peak_sensitivity <= limits.corner_peak &&
                    (!with_delay || worst.delay_margin_s >= limits.corner_delay_s);
  std::printf("  over %s, %s, %s: %speak sensitivity %.2f", over, channel, name,
              worst.stable ? "" : "UNSTABLE somewhere, ", worst.peak_sensitivity);
  nlohmann::json out{{"stable", worst.stable}, {"peak_sensitivity", worst.peak_sensitivity}, {"kept", kept}};
  if (with_delay) {
    std::printf(", delay margin %.0f ms", worst.delay_margin_s * 1e3);
    out["delay_margin_s"] = worst.delay_margin_s;
  }
  std::printf(" (%s)%s\n", worst.where.c_str(), kept ? "" : ": NOT KEPT");
  return out;
}

nlohmann::json report_flown_axis(const model::Vehicle& believed, const Structure& structure, const char* name,
                                 Axis axis) {
  nlohmann::json out;
  for (const auto& [channel, timing] : {std::pair{"virtual_rc", &kVirtualRcTiming}, {"movement", &kMovementTiming}}) {
    const Margins margins = flown_margins_of(believed, structure.vehicle, axis, *timing);
    std::printf(
        "%s as flown on %s, %s at %zu Hz, pose %zu ms old: %s, peak sensitivity %.2f, gain margin %.2f, phase margin "
        "%.0f deg, delay margin %.0f ms\n",
        name, structure.name.c_str(), channel, 100 / timing->command_ticks, 10 * timing->pose_age_ticks,
        margins.stable ? "stable" : "UNSTABLE", margins.peak_sensitivity, margins.gain_margin,
        margins.phase_margin_rad * 180.0 / core::kPi, margins.delay_margin_s * 1e3);
    out[channel] = margins_json(margins);
  }
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

nlohmann::json report_flown(const model::Vehicle& believed, const std::vector<OpenStructure>& structures,
                            const MarginLimits* limits) {
  nlohmann::json out;
  bool kept = true;
  std::optional<MarginBox> box;
  if (limits != nullptr) {
    box.emplace(structures);
  }
  for (std::size_t k = 0; k < structures.size(); ++k) {
    for (const auto& [name, axis] : {std::pair{"x", Axis::kX}, {"y", Axis::kY}}) {
      const Structure structure{structures[k].name, structures[k].vehicle};
      nlohmann::json& cell = out[structure.name][name] = report_flown_axis(believed, structure, name, axis);
      for (const auto& [channel, by_sticks] : {std::pair{"virtual_rc", true}, {"movement", false}}) {
        if (!box) {
          break;
        }
        const BoxSelection only{.structure = k, .axis = axis, .by_sticks = by_sticks};
        cell["corners"][channel] = report_worst(box->worst(believed, MarginBox::Extent::kCorners, only),
                                                "gain and frequency", channel, name, *limits, true);
        cell["box"][channel] = report_worst(box->worst(believed, MarginBox::Extent::kBox, only), "the whole box",
                                            channel, name, *limits, false);
        kept = kept && cell["corners"][channel]["kept"].get<bool>();
      }
    }
  }
  if (!kept) {
    std::printf(
        "warning: as flown, not every corner keeps a peak sensitivity of %.1f and %.0f ms of delay\n"
        "To distinguish the structures, fly stick steps (m100-lab excite --kind doublet) with the gyro logged: with a "
        "lead zero the aircraft rotates in the sample of the step, with a pure delay it does not.\n",
        limits->corner_peak, limits->corner_delay_s * 1e3);
  }
  return out;
}

}  // namespace m100::lab::gains
