// SPDX-License-Identifier: BSD-3-Clause
// The result of the loop as JSON and as text.
#include "host_tests/lab/loop/results.h"

#include <algorithm>
#include <array>
#include <ostream>

#include "firmware/companion/files/text/json.h"
#include "host_tests/lab/identify/output/result_text.h"
#include "host_tests/lab/loop/paired_flights.h"
#include "host_tests/lab/loop/trial_flights.h"
#include "host_tests/lab/plot/svg.h"
#include "host_tests/lab/printed.h"

namespace m100::lab::loop {
namespace {

Json json_of(const identify::Prediction& prediction, std::size_t horizon) {
  return {{"roll_rad", prediction.roll_rad[horizon]},     {"pitch_rad", prediction.pitch_rad[horizon]},
          {"position_m", prediction.position_m[horizon]}, {"velocity_m_s", prediction.velocity_m_s[horizon]},
          {"climb_m_s", prediction.climb_m_s[horizon]},   {"yaw_rate_rad_s", prediction.yaw_rate_rad_s[horizon]}};
}

Json json_of(const LoopEvaluation& side) {
  Json out;
  out["experiments"] = experiments::to_json(side.experiments);
  constexpr std::array kNames{"prediction_0.2s", "prediction_0.5s", "prediction_1s", "prediction_2s"};
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    out[kNames[i]] = json_of(side.prediction, i);
  }
  return out;
}

Json paired_json(const std::vector<experiments::TaskResult>& before,
                 const std::vector<experiments::TaskResult>& after) {
  Json out = Json::object();
  for (const auto& [task, pairs] : compare_tasks(before, after)) {
    out[task] = to_json(pairs);
  }
  return out;
}

void print_believed_found(std::ostream& out, const LoopResult& result) {
  out << "Believed -> found, with 95 % intervals; *: the difference matters for the prediction\n";
  for (const auto& [channel, rows] : result.believed_found) {
    for (const identify::Refitted& one : rows) {
      out << printed("  %-11s %-24s %10.5g -> %10.5g [%.5g, %.5g]%s\n", channel.c_str(), one.parameter.c_str(),
                     one.believed, one.found.value, one.found.low, one.found.high, one.matters ? " *" : "");
    }
  }
}

/// For example "dead_zone; trim_offset; gain changed at 31.2 s; unexplained: predictable from stick_roll ...".
std::string missing_effects(const identify::IdentifyResult& found) {
  std::vector<std::string> out;
  std::ranges::transform(found.effects, std::back_inserter(out), &identify::EffectResult::name);
  for (const identify::Change& change : found.changes) {
    out.push_back(change.name + " changed at " + plot::number(change.at_s) + " s");
  }
  if (!found.unexplained.empty()) {
    out.push_back("unexplained: " + found.unexplained.front());
  }
  const char* const none =
      found.verdict == "nothing_missing" ? "the file lacks nothing" : "the residual has no named cause";
  return out.empty() ? none : plot::joined(out, "; ");
}

}  // namespace

std::vector<std::string> predicted_worse(const LoopResult& result) {
  constexpr double kPredictedWorse = 1.02;
  std::vector<std::string> out;
  for (const identify::Quantity& row : identify::kQuantities) {
    const double before = (result.before.prediction.*row.member)[identify::kOneSecond];
    const double after = (result.after.prediction.*row.member)[identify::kOneSecond];
    if (after > kPredictedWorse * before) {
      out.push_back(std::string("the prediction of ") + row.name +
                    " 1 s ahead is worse on the third flight: " + printed("%.4f before, %.4f after", before, after));
    }
  }
  return out;
}

std::vector<std::string> verdicts(const LoopResult& result) {
  std::vector<std::string> out;
  const auto add = [&out](const std::string& words, const std::vector<experiments::TaskResult>& before,
                          const std::vector<experiments::TaskResult>& after) {
    for (const auto& [task, pairs] : compare_tasks(before, after)) {
      out.push_back(task + ", " + words + ", horizontal: " + describe(pairs.horizontal));
      out.push_back(task + ", " + words + ", vertical: " + describe(pairs.vertical));
    }
  };
  add("as flown", result.before.experiments, result.after.experiments);
  if (!out.empty()) {
    out.push_back(paired_rule());
  }
  const model::Vehicle& truth = result.vehicle.vehicle;
  if (!truth.roll.is_identified()) {
    return out;
  }
  const auto margins = [&truth](const char* words, const model::Vehicle& law) {
    const gains::TunedMargins kept = gains::margins_over(law, {{"", truth}});
    return std::string("margins on the corrected model, ") + words + ", " + gains::words(gains::kVirtualRcTiming) +
           ": " + (kept.stable ? "" : "UNSTABLE, ") +
           printed("peak sensitivity %.2f, delay margin %.0f ms", kept.peak_sensitivity, 1e3 * kept.delay_margin_s);
  };
  out.push_back(margins("law before", result.before_vehicle));
  out.push_back(margins("law after", truth));
  if (model::flown_weights(result.before_ordered.vehicle).input != model::flown_weights(result.before_vehicle).input) {
    out.push_back(
        "at equal margin: the law before is faster than ordered, because its model is wrong. Nobody flies it "
        "with " +
        printed("%.1f times its input weight (peak sensitivity at most %.1f is ordered):",
                model::flown_weights(result.before_ordered.vehicle).input /
                    model::flown_weights(result.before_vehicle).input,
                order_of(result.before_vehicle).peak_sensitivity));
    out.push_back(margins("law before, at equal margin", result.before_ordered.vehicle));
    add("at equal margin", result.ordered_experiments, result.after.experiments);
  }
  return out;
}

Json to_json(const LoopResult& result) {
  Json out;
  out["believed_found"] = Json::object();
  for (const auto& [channel, rows] : result.believed_found) {
    out["believed_found"][channel] = identify::to_json(rows);
  }
  out["taken_over"] = result.taken_over;
  out["predicted_worse"] = predicted_worse(result);
  out["before"] = json_of(result.before);
  out["after"] = json_of(result.after);
  for (const auto& [axis, found] : result.identified) {
    out["identified"][axis] = identify::to_json(found);
  }
  out["decisions"] = result.decisions;
  if (const model::Vehicle& corrected = result.vehicle.vehicle; corrected.roll.is_identified()) {
    const MarginOrder order = order_of(result.before_vehicle);
    out["margins"] = {{"before", margins_on(result.before_vehicle, corrected, order)},
                      {"after", margins_on(corrected, corrected, order)},
                      {"before_at_ordered_margin", margins_on(result.before_ordered.vehicle, corrected, order)}};
  }
  out["paired"] = paired_json(result.before.experiments, result.after.experiments);
  out["paired_at_ordered_margin"] = paired_json(result.ordered_experiments, result.after.experiments);
  out["paired_rule"] = paired_rule();
  out["kept"] = result.is_kept;
  return out;
}

void print(std::ostream& out, const LoopResult& result) {
  print_believed_found(out, result);
  for (const auto& [axis, found] : result.identified) {
    out << axis << ": " << found.verdict << ": " << missing_effects(found) << "\n";
  }
  for (const std::string& decision : result.decisions) {
    out << "  " << decision << "\n";
  }
  for (const std::string& sentence : predicted_worse(result)) {
    out << "  WORSE: " << sentence << "\n";
  }
  out << "\nPrediction error 1 s ahead on a third flight, which no fit and no decision used, before -> after\n";
  for (const identify::Quantity& row : identify::kQuantities) {
    out << "  " << row.name
        << printed(": %.4f -> %.4f\n", (result.before.prediction.*row.member)[identify::kOneSecond],
                   (result.after.prediction.*row.member)[identify::kOneSecond]);
  }
  out << "\nPose RMS [m] (simulated), before -> after\n";
  for (std::size_t i = 0; i < result.before.experiments.size() && i < result.after.experiments.size(); ++i) {
    const experiments::TaskResult& before = result.before.experiments[i];
    const experiments::TaskResult& after = result.after.experiments[i];
    out << "  " << before.task->task << " " << before.task->condition << ": "
        << (diverged(before) || diverged(after) ? std::string("DIVERGED ") : std::string())
        << printed("%.4f -> %.4f", before.mean.pose_m, after.mean.pose_m)
        << printed("  (tilt %.2f -> %.2f deg)", before.mean.tilt_deg, after.mean.tilt_deg) << "\n";
  }
  for (const std::string& line : verdicts(result)) {
    out << line << "\n";
  }
  if (!result.is_kept) {
    out << kNotKept << "\n";
  }
}

}  // namespace m100::lab::loop
