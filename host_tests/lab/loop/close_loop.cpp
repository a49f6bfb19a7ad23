// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/loop/close_loop.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <stdexcept>

#include "host_tests/lab/gains/gain_tables.h"
#include "host_tests/lab/identify/axis_pipeline.h"
#include "host_tests/lab/identify/output/vehicle_update.h"
#include "host_tests/lab/identify/request.h"
#include "host_tests/lab/identify/translation_pipeline.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/loop/aligned_log.h"
#include "host_tests/lab/loop/log_folder.h"
#include "host_tests/lab/loop/trial_flights.h"
#include "host_tests/lab/loop/vehicle_comparison.h"
#include "host_tests/lab/printed.h"

namespace m100::lab::loop {

FlownLog fly_and_log(const LoopOptions& options, std::uint64_t seed, const std::string& file) {
  experiments::FlightPlan plan = options.plan;
  plan.course = excitation(seed, options.flight_s);
  plan.duration_s = options.flight_s;
  plan.seed = seed;
  plan.keep_log = true;
  const experiments::FlightResult flight = experiments::fly(plan);
  if (!flight.flew) {
    throw InputError("loop", 0, "", "control was never obtained: there is no flight to identify from");
  }
  return load_flown(flight, file);
}

identify::Range flown(const FlownLog& flight) {
  constexpr double kSettled_s = 1.0;
  constexpr double kLast_s = 0.3;  // the shifted position and velocity are not measured at their end
  const auto [from_s, to_s] = flight.in_control;
  return {std::min(from_s + kSettled_s, to_s), std::max(from_s, to_s - kLast_s)};
}

std::vector<experiments::TaskResult> fly_tasks(const LoopOptions& options, const companion::VehicleFile& vehicle,
                                               std::uint64_t seed, const std::vector<std::string>& tasks, int seeds) {
  experiments::SuiteOptions suite;
  suite.plan = options.plan;
  suite.plan.vehicle = vehicle;
  suite.seed = seed;
  suite.seeds = seeds;
  suite.literal_steps = false;
  std::vector<experiments::TaskResult> out;
  for (const std::string& task : tasks) {
    suite.only = task;
    for (experiments::TaskResult& result : experiments::fly_suite(suite)) {
      out.push_back(std::move(result));
    }
  }
  return out;
}

namespace {

constexpr std::array kChannels{"roll", "pitch", "climb", "yaw_rate", "translation"};

class Loop {
 public:
  explicit Loop(const LoopOptions& options) : options_(options), believed_(options.plan.vehicle.vehicle) {
    result_.vehicle = options.plan.vehicle;
    result_.before_vehicle = options.plan.vehicle.vehicle;
    result_.before_ordered.vehicle = options.plan.vehicle.vehicle;
  }

  LoopResult run() {
    report_progress("flying the present vehicle");
    result_.before.experiments =
        fly_tasks(options_, options_.plan.vehicle, options_.seed, options_.tasks, options_.seeds);
    const LogFolder folder(options_.log_folder);
    const FlownLog first = control_range(options_.seed + 101, folder.file("loop_train.ulg"));
    const FlownLog second = control_range(options_.seed + 202, folder.file("loop_validate.ulg"));
    const FlownLog third = control_range(options_.seed + 404, folder.file("loop_quote.ulg"));
    std::set<std::string> better;
    for (const char* const channel : kChannels) {
      report_progress(std::string("identifying ") + channel);
      if (identify_channels(channel, first, second)) {
        better.insert(channel);
      }
    }
    take_over(better);
    quote(third);
    if (result_.taken_over.empty()) {
      result_.after.experiments = result_.before.experiments;  // the same vehicle and seeds: the same numbers
      result_.ordered_experiments = result_.before.experiments;
      return std::move(result_);
    }
    report_progress("flying the new vehicle");
    result_.after.experiments = fly_tasks(options_, result_.vehicle, options_.seed, options_.tasks, options_.seeds);
    const bool as_flown =
        model::flown_weights(result_.before_ordered.vehicle).input == model::flown_weights(believed_).input;
    result_.ordered_experiments = as_flown ? result_.before.experiments
                                           : fly_tasks(options_, companion::as_file(result_.before_ordered.vehicle),
                                                       options_.seed, options_.tasks, options_.seeds);
    result_.is_kept = options_.keep_worse || !is_worse(result_.after.experiments, result_.before.experiments);
    return std::move(result_);
  }

 private:
  void report_progress(const std::string& line) const {
    if (options_.progress) {
      options_.progress(line);
    }
  }

  /// A flight that is under control for at least 80 % of its time. One that is not is flown again on another course, up
  /// to four flights in all; if all end early, the longest one is used.
  FlownLog control_range(std::uint64_t seed, const std::string& file) {
    constexpr std::uint64_t kAnother = 1000;
    constexpr int kFlights = 4;
    constexpr double kMax = 0.8;  // of the flight
    const std::filesystem::path path(file);
    FlownLog best;
    for (int flight = 0; flight < kFlights; ++flight) {
      const std::string name = path.stem().string() + (flight == 0 ? "" : "_" + std::to_string(flight + 1)) + ".ulg";
      FlownLog next = fly_and_log(options_, seed + static_cast<std::uint64_t>(flight) * kAnother,
                                  (path.parent_path() / name).string());
      const double length_s = next.in_control.second - next.in_control.first;
      std::string messages = name + printed(": under control for %.1f s of %.0f s", length_s, options_.flight_s) +
                             ", ended by " + next.descent +
                             (flight + 1 < kFlights ? ": flown again" : ": the longest of these flights is used");
      if (flight == 0 || length_s > best.in_control.second - best.in_control.first) {
        best = std::move(next);
      }
      if (length_s >= kMax * options_.flight_s) {
        break;
      }
      result_.decisions.push_back(std::move(messages));
    }
    return best;
  }

  /// Identifies one channel from the first flight. @returns whether its model gives a controller and predicts the
  /// second flight better
  bool identify_channels(const std::string& channel, const FlownLog& first, const FlownLog& second) {
    const bool translation = channel == "translation";
    identify::Request request;
    request.axis = channel;
    request.declared = declared(believed_, channel);
    request.log = &first.log;
    request.validation_log = &second.log;
    request.train = {flown(first)};
    request.validate = {flown(second)};
    request.refits = 40;
    try {
      identify::IdentifyResult found =
          translation ? identify::identify_translation(request) : identify::identify_axis(request);
      model::Vehicle candidate = believed_;
      const std::vector<std::string> not_in_file = identify::put_axis(found, candidate);
      const identify::UnseenFlight flight{&second.log, request.validate};
      found.refitted = believed_and_found(believed_, found, channel, flight, candidate);
      result_.believed_found[channel] = found.refitted;
      result_.identified[channel] = std::move(found);
      result_.decisions.insert(result_.decisions.end(), not_in_file.begin(), not_in_file.end());
      const std::string why = uncontrollable(with_channel(believed_, candidate, channel));
      if (!why.empty()) {
        result_.decisions.push_back(channel +
                                    ": left as it was, no controller can be made from the found model: " + why);
        return false;
      }
      return judge(channel, flight, candidate);
    } catch (const InputError& error) {
      result_.decisions.push_back(channel + ": left as it was: " + error.what());
      return false;
    }
  }

  bool judge(const std::string& channel, const identify::UnseenFlight& flight, const model::Vehicle& candidate) {
    const double before = identify::error_at_1s(believed_, flight, channel);
    const double after = identify::error_at_1s(candidate, flight, channel);
    const bool better = predicts_better(believed_, candidate, flight, channel);
    candidates_[channel] = candidate;
    result_.decisions.push_back(channel + (better ? ": predicts better, " : ": left as it was, ") +
                                printed("1 s ahead on the second flight %.4f before, %.4f after", before, after));
    return better;
  }

  companion::VehicleFile vehicle_with(const std::set<std::string>& channels) const {
    model::Vehicle vehicle = believed_;
    std::map<std::string, std::string> sources = options_.plan.vehicle.sources;
    for (const std::string& channel : channels) {
      vehicle = with_channel(vehicle, candidates_.at(channel), channel);
      sources[(channel == "translation" ? "" : "axis.") + channel] =
          "m100-lab loop, identification flight of " + std::to_string(static_cast<int>(options_.flight_s)) +
          " s, validated on a second one";
    }
    return companion::as_file(at_ordered_margin(vehicle, vehicle, order_of(believed_)).vehicle, sources);
  }

  /// Separate trial flights decide which of the channels that predict better are kept. The laws of the old and the new
  /// vehicle file fly at the same margin (ordered_margin.h): otherwise a wrong model could win by giving margin away.
  void take_over(const std::set<std::string>& better) {
    if (better.empty()) {
      return;
    }
    report_progress("trial flights");
    constexpr int kTrialSeeds = 5;
    const auto fly = [&](const companion::VehicleFile& vehicle) {
      return fly_tasks(options_, vehicle, options_.seed + 303, {"hover", "trajectory"}, kTrialSeeds);
    };
    result_.before_ordered = at_ordered_margin(believed_, vehicle_with(better).vehicle, order_of(believed_));
    const Trial trial = fly_trials(better, fly(companion::as_file(result_.before_ordered.vehicle)),
                                   [&](const std::set<std::string>& channels) { return fly(vehicle_with(channels)); });
    result_.decisions.insert(result_.decisions.end(), trial.messages.begin(), trial.messages.end());
    result_.taken_over = trial.kept;
    if (!trial.kept.empty()) {
      result_.vehicle = vehicle_with(trial.kept);
      result_.before_ordered = at_ordered_margin(believed_, result_.vehicle.vehicle, order_of(believed_));
    }
  }

  /// Computes the published predictions, on a flight that decided nothing.
  void quote(const FlownLog& third) {
    const identify::UnseenFlight flight{&third.log, {flown(third)}};
    result_.before.prediction = identify::predict(believed_, flight);
    result_.after.prediction = identify::predict(result_.vehicle.vehicle, flight);
  }

  const LoopOptions& options_;
  const model::Vehicle& believed_;
  std::map<std::string, model::Vehicle> candidates_;
  LoopResult result_;
};

}  // namespace

std::string uncontrollable(const model::Vehicle& vehicle) {
  try {
    static_cast<void>(gains::make_gain_tables(vehicle));
    return "";
  } catch (const std::domain_error& wrong) {
    return wrong.what();
  }
}

TrajectoryErrors trajectory_errors(const LoopResult& result) {
  TrajectoryErrors out;
  for (std::size_t i = 0; i < std::min(result.before.experiments.size(), result.after.experiments.size()); ++i) {
    const experiments::TaskResult& before = result.before.experiments[i];
    const experiments::TaskResult& after = result.after.experiments[i];
    for (const auto& [cell, when] : {std::pair{&before, " before"}, std::pair{&after, " after"}}) {
      if (diverged(*cell)) {
        out.diverged.push_back(cell->task->task + ", " + cell->task->condition + when);
      }
    }
    if (before.task->task == "trajectory" && !diverged(before) && !diverged(after)) {
      out.before_m = std::hypot(out.before_m, before.mean.pose_m);
      out.after_m = std::hypot(out.after_m, after.mean.pose_m);
      ++out.cells;
    }
  }
  out.before_m /= std::sqrt(std::max(1, out.cells));
  out.after_m /= std::sqrt(std::max(1, out.cells));
  return out;
}

LoopResult close_loop(const LoopOptions& options) { return Loop(options).run(); }

}  // namespace m100::lab::loop
