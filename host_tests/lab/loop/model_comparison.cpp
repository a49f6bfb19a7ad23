// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/loop/model_comparison.h"

#include <array>

#include "host_tests/lab/loop/aligned_log.h"
#include "host_tests/lab/loop/log_folder.h"
#include "host_tests/lab/loop/paired_flights.h"
#include "host_tests/lab/loop/trial_flights.h"
#include "host_tests/lab/printed.h"

namespace m100::lab::loop {
namespace {

/// Flies the tasks with one model and writes its errors.
void fly_model(const LoopOptions& options, const ComparedModel& model, ModelScore& score) {
  for (const std::string& task : options.tasks) {
    Squares sums;
    double cells = 0.0;
    for (const experiments::TaskResult& cell : fly_tasks(options, model.vehicle, options.seed, {task}, options.seeds)) {
      if (cell.flights.size() != static_cast<std::size_t>(options.seeds) || diverged(cell)) {
        score.diverged.push_back(task + ", " + cell.task->condition);
        continue;
      }
      add(cell.flights, sums);
      cells += 1.0;
    }
    if (cells > 0.0) {
      score.pose_m[task] = mean_with_interval(root_mean(sums[0], cells));
      score.horizontal_m[task] = mean_with_interval(root_mean(sums[1], cells));
    }
  }
}

/// The errors 1 s ahead of every model, one for each seed: [model][quantity][seed].
using ModelErrors = std::vector<std::array<std::vector<double>, identify::kQuantities.size()>>;
ModelErrors predict_all(const LoopOptions& options, const std::vector<ComparedModel>& models) {
  LoopOptions excited = options;
  excited.plan.vehicle = models.back().vehicle;
  const LogFolder folder(options.log_folder);
  ModelErrors errors(models.size());
  for (int i = 0; i < options.seeds; ++i) {
    const FlownLog flight =
        fly_and_log(excited, options.seed + static_cast<std::uint64_t>(i), folder.file("models.ulg"));
    for (std::size_t m = 0; m < models.size(); ++m) {
      const identify::Prediction found = identify::predict(models[m].vehicle.vehicle, {&flight.log, {flown(flight)}});
      for (std::size_t q = 0; q < identify::kQuantities.size(); ++q) {
        errors[m][q].push_back((found.*identify::kQuantities[q].member)[identify::kOneSecond]);
      }
    }
  }
  return errors;
}

Json json_of(const std::map<std::string, Interval>& intervals) {
  Json out = Json::object();
  for (const auto& [name, interval] : intervals) {
    out[name] = {{"value", interval.value}, {"low", interval.low}, {"high", interval.high}};
  }
  return out;
}

void print(std::ostream& out, const char* what, const std::map<std::string, Interval>& intervals) {
  for (const auto& [name, interval] : intervals) {
    out << printed("  %-10s %-28s %.4f [%.4f, %.4f]\n", what, name.c_str(), interval.value, interval.low,
                   interval.high);
  }
}

}  // namespace

std::vector<ModelScore> compare_models(const LoopOptions& options, const std::vector<ComparedModel>& models,
                                       const model::Vehicle& truth) {
  const ModelErrors errors = predict_all(options, models);
  std::vector<ModelScore> scores(models.size());
  for (std::size_t m = 0; m < models.size(); ++m) {
    ModelScore& score = scores[m];
    score.name = models[m].name;
    if (options.progress) {
      options.progress("flying " + score.name);
    }
    for (std::size_t q = 0; q < identify::kQuantities.size(); ++q) {
      score.prediction_1s[identify::kQuantities[q].name] = mean_with_interval(errors[m][q]);
    }
    fly_model(options, models[m], score);
    score.margins = gains::margins_over(models[m].vehicle.vehicle, {{"the plant", truth}});
  }
  return scores;
}

void print(std::ostream& out, const std::vector<ModelScore>& scores) {
  for (const ModelScore& score : scores) {
    out << score.name << "\n";
    print(out, "1 s ahead", score.prediction_1s);
    print(out, "pose", score.pose_m);
    print(out, "horizontal", score.horizontal_m);
    for (const std::string& cell : score.diverged) {
      out << "  " << cell << ": flew away, or never obtained control\n";
    }
    out << printed("  margins    %s: peak sensitivity %.2f, delay margin %.0f ms%s\n",
                   gains::words(gains::kVirtualRcTiming).c_str(), score.margins.peak_sensitivity,
                   1e3 * score.margins.delay_margin_s, score.margins.stable ? "" : ", unstable");
  }
}

Json to_json(const std::vector<ModelScore>& scores) {
  Json out = Json::array();
  for (const ModelScore& score : scores) {
    out.push_back({{"name", score.name},
                   {"prediction_1s", json_of(score.prediction_1s)},
                   {"pose_m", json_of(score.pose_m)},
                   {"horizontal_m", json_of(score.horizontal_m)},
                   {"diverged", score.diverged},
                   {"margins",
                    {{"stable", score.margins.stable},
                     {"peak_sensitivity", score.margins.peak_sensitivity},
                     {"delay_margin_s", score.margins.delay_margin_s}}}});
  }
  return out;
}

}  // namespace m100::lab::loop
