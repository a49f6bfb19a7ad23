// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/loop/close_loop.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "host_tests/lab/identify/answer/to_vehicle.h"
#include "host_tests/lab/identify/request.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/loop/flown_log.h"

namespace m100::lab::loop {
namespace {

constexpr double kLeastGain = 0.02;
constexpr std::array kAxes{"roll", "pitch", "climb", "yaw_rate"};

std::string text(const char* format, double a, double b) {
  std::array<char, 128> out{};
  std::snprintf(out.data(), out.size(), format, a, b);
  return out.data();
}

/// One flight whose log is kept, and nothing else of it.
logs::FlightLog fly_and_log(const LoopOptions& options, std::uint64_t seed, const std::string& name) {
  experiments::FlightPlan plan;
  plan.plant = options.plant;
  plan.vehicle = options.vehicle;
  plan.course = excitation(seed, options.flight_s);
  plan.duration_s = options.flight_s;
  plan.seed = seed;
  plan.keep_log = true;
  plan.law = options.law;
  const experiments::FlightResult flight = experiments::fly(plan);
  if (!flight.flew) {
    throw InputError("loop", 0, "", "control was never obtained: no flight to learn from");
  }
  return load_flown(flight, (std::filesystem::path(options.work_folder) / name).string());
}

/// The part of a log that was flown under control, without start-up and hand-over.
identify::Range flown(const logs::FlightLog& log, double flight_s) {
  const double end_s = log.time_s(log.size - 1) - 4.2;
  return {std::max(log.start_s, end_s - flight_s + 1.0), end_s};
}

std::vector<std::string> declared(const model::StickAxis& axis) {
  std::vector<std::string> out{axis.time_constant_s > 0.0 ? "first_order" : "second_order"};
  const auto add = [&out](bool has, const char* name) {
    if (has) {
      out.emplace_back(name);
    }
  };
  add(axis.transport_delay_s > 0.0, "transport_delay");
  add(axis.dead_zone_counts > 0.0, "dead_zone");
  add(axis.trim_counts != 0.0, "trim_offset");
  add(axis.stick_exponent != 1.0, "stick_curve");
  add(axis.gain_asymmetry != 1.0, "gain_asymmetry");
  return out;
}

std::vector<std::string> declared(const model::Vehicle& vehicle, const std::string& axis) {
  return axis == "roll"    ? declared(vehicle.roll)
         : axis == "pitch" ? declared(vehicle.pitch)
         : axis == "climb" ? declared(vehicle.climb)
                           : declared(vehicle.yaw_rate);
}

/// 1 s prediction errors of one axis, before and after.
double one_second(const Prediction& prediction, const std::string& axis) {
  return axis == "roll" ? prediction.roll_rad[2] : axis == "pitch" ? prediction.pitch_rad[2] : prediction.climb_m_s[2];
}

std::vector<experiments::TaskResult> tables(const LoopOptions& options, const companion::VehicleFile& vehicle,
                                            std::uint64_t seed, const std::vector<std::string>& tasks, int seeds) {
  experiments::SuiteOptions suite;
  suite.plant = options.plant;
  suite.vehicle = vehicle;
  suite.seed = seed;
  suite.seeds = seeds;
  suite.law = options.law;
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

class Loop {
 public:
  explicit Loop(const LoopOptions& options) : options_(options) { result_.vehicle = options.vehicle; }

  LoopResult run() {
    tell("flying the present vehicle");
    result_.before.experiments = tables(options_, options_.vehicle, options_.seed, options_.tasks, options_.seeds);
    const logs::FlightLog first = fly_and_log(options_, options_.seed + 101, "loop_train.ulg");
    const logs::FlightLog second = fly_and_log(options_, options_.seed + 202, "loop_validate.ulg");
    const identify::Range unseen = flown(second, options_.flight_s);
    result_.before.prediction = predict(options_.vehicle.vehicle, second, unseen.first, unseen.second);
    model::Vehicle vehicle = options_.vehicle.vehicle;
    for (const char* const axis : kAxes) {
      tell(std::string("identifying ") + axis);
      learn(axis, first, second, vehicle);
    }
    const model::Vehicle axes_only = vehicle;
    tell("identifying translation");
    const bool moved = learn_translation(first, second, vehicle);
    if (!trial(vehicle) && moved) {
      trial(axes_only);
    }
    result_.after.prediction = predict(result_.vehicle.vehicle, second, unseen.first, unseen.second);
    tell("flying the new vehicle");
    result_.after.experiments = tables(options_, result_.vehicle, options_.seed, options_.tasks, options_.seeds);
    return std::move(result_);
  }

 private:
  void tell(const std::string& line) const {
    if (options_.progress) {
      options_.progress(line);
    }
  }

  void learn(const std::string& axis, const logs::FlightLog& first, const logs::FlightLog& second,
             model::Vehicle& vehicle) {
    identify::Request request;
    request.axis = axis;
    request.declared = declared(options_.vehicle.vehicle, axis);
    request.log = &first;
    request.validation_log = &second;
    request.train = {flown(first, options_.flight_s)};
    request.validate = {flown(second, options_.flight_s)};
    request.bootstrap_draws = 40;
    try {
      const identify::IdentifyResult found = identify::identify_axis(request);
      result_.identified[axis] = found;
      model::Vehicle candidate = vehicle;
      const std::vector<std::string> homeless = identify::put_axis(found, candidate);
      judge(axis, found, second, request.validate.front(), candidate, vehicle);
      result_.decisions.insert(result_.decisions.end(), homeless.begin(), homeless.end());
    } catch (const InputError& error) {
      result_.decisions.push_back(axis + ": left as it was: " + error.what());
    }
  }

  /// Takes the axis over if it predicts the unseen flight better than the present vehicle does.
  void judge(const std::string& axis, const identify::IdentifyResult& found, const logs::FlightLog& second,
             const identify::Range& unseen, const model::Vehicle& candidate, model::Vehicle& vehicle) {
    if (axis == "yaw_rate") {
      vehicle = candidate;
      result_.decisions.push_back(axis + ": taken over, " +
                                  text("%.4f rad/s on the unseen flight (refitted as declared: %.4f)",
                                       found.final_model.validation_rmse, found.declared.validation_rmse));
      return;
    }
    const double before = one_second(predict(vehicle, second, unseen.first, unseen.second), axis);
    const double after = one_second(predict(candidate, second, unseen.first, unseen.second), axis);
    const bool better = after < (1.0 - kLeastGain) * before;
    if (better) {
      vehicle = candidate;
    }
    result_.decisions.push_back(axis + (better ? ": taken over, " : ": left as it was, ") +
                                text("1 s prediction %.4f before, %.4f after", before, after));
  }

  /// Drag and gains, if they predict the velocity of the unseen flight better. @returns whether they were taken over.
  bool learn_translation(const logs::FlightLog& first, const logs::FlightLog& second, model::Vehicle& vehicle) {
    const logs::FlightLog seen = with_captured_velocity(first);
    const logs::FlightLog unseen = with_captured_velocity(second);
    identify::Request request;
    request.axis = "translation";
    request.declared = {"rigid_body"};
    request.log = &seen;
    request.validation_log = &unseen;
    request.train = {flown(first, options_.flight_s)};
    request.validate = {flown(second, options_.flight_s)};
    request.bootstrap_draws = 40;
    try {
      const identify::IdentifyResult found = identify::identify_translation(request);
      result_.identified["translation"] = found;
      model::Vehicle candidate = vehicle;
      const std::vector<std::string> homeless = identify::put_axis(found, candidate);
      result_.decisions.insert(result_.decisions.end(), homeless.begin(), homeless.end());
      const identify::Range& range = request.validate.front();
      const double before = predict(vehicle, second, range.first, range.second).velocity_m_s[2];
      const double after = predict(candidate, second, range.first, range.second).velocity_m_s[2];
      const bool better = after < (1.0 - kLeastGain) * before;
      if (better) {
        vehicle = candidate;
      }
      result_.decisions.push_back(std::string("translation") + (better ? ": taken over, " : ": left as it was, ") +
                                  text("1 s prediction of the velocity %.4f m/s before, %.4f after", before, after));
      return better;
    } catch (const InputError& error) {
      result_.decisions.push_back(std::string("translation: left as it was: ") + error.what());
      return false;
    }
  }

  /// A flight of its own decides whether the new vehicle may stay. @returns whether it may.
  bool trial(const model::Vehicle& vehicle) {
    std::map<std::string, std::string> sources = options_.vehicle.sources;
    for (const auto& [axis, found] : result_.identified) {
      sources[(axis == "translation" ? "" : "axis.") + axis] =
          "m100-lab loop, two identification flights of " + std::to_string(static_cast<int>(options_.flight_s)) + " s";
    }
    const companion::VehicleFile candidate = companion::as_file(vehicle, sources);
    const std::uint64_t seed = options_.seed + 303;
    const double before = trajectory_error_m(tables(options_, options_.vehicle, seed, {"trajectory"}, 1));
    const double after = trajectory_error_m(tables(options_, candidate, seed, {"trajectory"}, 1));
    const bool keep = after <= before;
    result_.decisions.push_back(std::string(keep ? "kept" : "taken back") + " after a trial flight: " +
                                text("pose RMS %.4f m before, %.4f m after", before, after));
    result_.vehicle = keep ? candidate : options_.vehicle;
    return keep;
  }

  const LoopOptions& options_;
  LoopResult result_;
};

}  // namespace

double trajectory_error_m(const std::vector<experiments::TaskResult>& results) {
  double sum = 0.0;
  double count = 0.0;
  for (const experiments::TaskResult& result : results) {
    if (result.task->task == "trajectory") {
      sum += result.refused > 0 ? 1e6 : result.mean.pose_m * result.mean.pose_m;
      count += 1.0;
    }
  }
  return count > 0.0 ? std::sqrt(sum / count) : 0.0;
}

LoopResult close_loop(const LoopOptions& options) { return Loop(options).run(); }

}  // namespace m100::lab::loop
