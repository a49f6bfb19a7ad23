// SPDX-License-Identifier: BSD-3-Clause
// What the loop found: as JSON and as text.
#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <ostream>

#include "host_tests/lab/identify/answer/json.h"
#include "host_tests/lab/loop/close_loop.h"

namespace m100::lab::loop {
namespace {

std::string text(const char* format, double a, double b) {
  std::array<char, 128> out{};
  std::snprintf(out.data(), out.size(), format, a, b);
  return out.data();
}

nlohmann::json json_of(const Prediction& prediction, std::size_t horizon) {
  return {{"roll_rad", prediction.roll_rad[horizon]},
          {"pitch_rad", prediction.pitch_rad[horizon]},
          {"velocity_m_s", prediction.velocity_m_s[horizon]},
          {"climb_m_s", prediction.climb_m_s[horizon]}};
}

nlohmann::json json_of(const Side& side) {
  nlohmann::json out;
  out["experiments"] = experiments::to_json(side.experiments);
  constexpr std::array kNames{"prediction_0.2s", "prediction_0.5s", "prediction_1s", "prediction_2s"};
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    out[kNames[i]] = json_of(side.prediction, i);
  }
  return out;
}

}  // namespace

nlohmann::json to_json(const LoopResult& result) {
  nlohmann::json out;
  out["before"] = json_of(result.before);
  out["after"] = json_of(result.after);
  for (const auto& [axis, found] : result.identified) {
    out["identified"][axis] = nlohmann::json::parse(identify::to_json(found).dump());
  }
  out["decisions"] = result.decisions;
  return out;
}

void print(std::ostream& out, const LoopResult& result) {
  for (const auto& [axis, found] : result.identified) {
    out << axis << ": " << found.verdict << ":";
    for (const identify::EffectResult& effect : found.effects) {
      out << " " << effect.name;
    }
    out << "\n";
  }
  for (const std::string& decision : result.decisions) {
    out << "  " << decision << "\n";
  }
  out << "\nPrediction on the unseen flight, 1 s ahead: roll "
      << text("%.4f -> %.4f rad", result.before.prediction.roll_rad[2], result.after.prediction.roll_rad[2])
      << ", pitch "
      << text("%.4f -> %.4f rad", result.before.prediction.pitch_rad[2], result.after.prediction.pitch_rad[2])
      << ", velocity "
      << text("%.3f -> %.3f m/s", result.before.prediction.velocity_m_s[2], result.after.prediction.velocity_m_s[2])
      << ", climb "
      << text("%.3f -> %.3f m/s", result.before.prediction.climb_m_s[2], result.after.prediction.climb_m_s[2])
      << "\n\nPose RMS [m] (simulated), before -> after\n";
  for (std::size_t i = 0; i < result.before.experiments.size() && i < result.after.experiments.size(); ++i) {
    const experiments::TaskResult& before = result.before.experiments[i];
    const experiments::TaskResult& after = result.after.experiments[i];
    out << "  " << before.task->task << " " << before.task->condition << ": "
        << text("%.4f -> %.4f", before.mean.pose_m, after.mean.pose_m)
        << text("  (tilt %.2f -> %.2f deg)", before.mean.tilt_deg, after.mean.tilt_deg) << "\n";
  }
}

}  // namespace m100::lab::loop
