// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/hidden/confusion.h"

#include <algorithm>
#include <atomic>
#include <map>
#include <mutex>
#include <random>
#include <thread>

#include "firmware/model/axis_effects.h"
#include "firmware/model/translation.h"
#include "host_tests/lab/hidden/effect_sizes.h"
#include "host_tests/lab/identify/axis_pipeline.h"
#include "host_tests/lab/identify/request.h"
#include "host_tests/lab/identify/translation_pipeline.h"
#include "host_tests/lab/plot/svg.h"

namespace m100::lab::hidden {
namespace {

using Names = std::vector<std::string>;

/// Every effect of model::kAxisEffects, without the base models, that the hidden flights may contain.
Names axis_effects() {
  Names out;
  for (const model::AxisEffect& effect : model::kAxisEffects) {
    if (!model::is_base(effect) && supports_effect(std::string(effect.name))) {
      out.emplace_back(effect.name);
    }
  }
  return out;
}

/// The library's effects of translation that the hidden flights contain, with or without a logged thrust set point.
Names translation_effects(bool with_thrust) {
  Names out;
  for (const model::TranslationEffect& effect : model::kTranslationEffects) {
    if (effect.needs.thrust_set_point == with_thrust && supports_effect(std::string(effect.name))) {
      out.emplace_back(effect.name);
    }
  }
  return out;
}
const Names kRoll = axis_effects();
const Names kTranslation = translation_effects(false);
const Names kThrust = translation_effects(true);
const std::vector<std::pair<std::string, std::string>> kRollPairs{
    {"transport_delay", "dead_zone"}, {"dead_zone", "trim_offset"}, {"gain_asymmetry", "transport_delay"},
    {"saturation", "cross_axis"},     {"rate_limit", "dead_zone"},  {"trim_offset", "transport_delay"}};
const std::vector<std::pair<std::string, std::string>> kTranslationPairs{{"steady_wind", "linear_drag"},
                                                                         {"tilt_gain", "steady_wind"},
                                                                         {"periodic_wind", "linear_drag"},
                                                                         {"time_offset", "steady_wind"},
                                                                         {"yaw_misalignment", "linear_drag"}};

/// The names that count as right for this hidden effect, because the data of one axis may not distinguish them.
Names counting_for(const std::string& effect) {
  if (effect == "transport_delay" || effect == "lead_zero") {
    return effect == "lead_zero" ? Names{"lead_zero"} : Names{"transport_delay", "lead_zero"};
  }
  if (effect == "saturation" || effect == "tilt_limit") {
    return {"saturation", "tilt_limit"};
  }
  return {effect};
}

bool contains(const Names& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

Case make(const std::string& axis, const Names& effects, int size, std::uint64_t seed) {
  Case out;
  out.plan.axis = axis;
  out.plan.seed = seed;
  out.size = size;
  bool delay_hidden = false;
  for (std::size_t k = 0; k < effects.size(); ++k) {
    out.plan.hidden[effects[k]] = size_of(effects[k], size, seed + 77 * k);
    delay_hidden = delay_hidden || effects[k] == "transport_delay" || effects[k] == "lead_zero";
    out.plan.logs_thrust = out.plan.logs_thrust || contains(kThrust, effects[k]);
    out.label += (k > 0 ? " + " : axis + " ") + effects[k];
  }
  out.declare = axis == "translation" ? Names{"rigid_body"}
                : delay_hidden        ? Names{"second_order"}
                                      : Names{"second_order", "transport_delay"};
  for (const std::string& effect : effects) {
    out.expected.push_back(counting_for(effect));
  }
  out.verdict = effects.empty() ? "nothing_missing" : "explained";
  out.group = effects.empty() ? "none" : effects.size() == 1 ? "single" : "pair";
  return out;
}

Case outside(const std::string& axis, const std::string& effect, int size, std::uint64_t seed) {
  Case out = make(axis, {effect}, size, seed);
  out.expected.clear();
  out.verdict = "unexplained";
  out.group = "outside";
  return out;
}

std::vector<std::function<Case(std::uint64_t)>> recipes() {
  std::vector<std::function<Case(std::uint64_t)>> out;
  const auto nothing = [&](bool thrust) {
    out.push_back([](std::uint64_t seed) {
      Case one = make("roll", {}, 1, seed);
      one.label = "roll nothing";
      return one;
    });
    out.push_back([thrust](std::uint64_t seed) {
      Case one = make("translation", {}, 1, seed);
      one.plan.logs_thrust = thrust;
      one.label = "translation nothing";
      return one;
    });
  };
  const auto single = [&](const std::string& axis, const std::string& effect) {
    for (const int size : {1, 0, 2, 1}) {
      out.push_back([=](std::uint64_t seed) { return make(axis, {effect}, size, seed); });
    }
  };
  for (int k = 0; k < 5; ++k) {
    nothing(k % 2 == 1);
  }
  for (const std::string& effect : kRoll) {
    single("roll", effect);
  }
  for (const Names& names : {kTranslation, kThrust}) {
    for (const std::string& effect : names) {
      single("translation", effect);
    }
  }
  for (const auto& [a, b] : kRollPairs) {
    out.push_back([a = a, b = b](std::uint64_t seed) { return make("roll", {a, b}, 1, seed); });
  }
  for (const auto& [a, b] : kTranslationPairs) {
    out.push_back([a = a, b = b](std::uint64_t seed) { return make("translation", {a, b}, 1, seed); });
  }
  for (const int size : {1, 2}) {
    for (const char* effect : {"sine", "dropout", "product"}) {
      out.push_back([=](std::uint64_t seed) { return outside("roll", effect, size, seed); });
    }
    for (const char* effect : {"slung_load", "product"}) {
      out.push_back([=](std::uint64_t seed) { return outside("translation", effect, size, seed); });
    }
  }
  return out;
}

/// Whether the verdict is right and, inside the library, exactly the expected effects are named, by allowed names or
/// (`rivals_count`) by names that the log cannot separate from those.
bool matches(const Outcome& outcome, bool rivals_count) {
  const Case& hidden_case = outcome.hidden_case;
  if (outcome.verdict != hidden_case.verdict) {
    return false;
  }
  if (hidden_case.group == "outside") {
    return true;
  }
  if (outcome.found.size() != hidden_case.expected.size()) {
    return false;
  }
  return std::all_of(hidden_case.expected.begin(), hidden_case.expected.end(), [&](const Names& allowed) {
    return std::any_of(outcome.found.begin(), outcome.found.end(), [&](const std::string& name) {
      if (contains(allowed, name)) {
        return true;
      }
      return rivals_count &&
             std::any_of(outcome.not_separable.begin(), outcome.not_separable.end(), [&](const Names& group) {
               return contains(group, name) && std::any_of(allowed.begin(), allowed.end(), [&](const std::string& one) {
                        return contains(group, one);
                      });
             });
    });
  });
}

/// The row of scores() in which an outcome is counted.
std::size_t row_of(const Outcome& one) {
  if (one.hidden_case.group == "none") {
    return 0;
  }
  if (one.hidden_case.group == "single") {
    return one.hidden_case.size == 1 ? 1 : one.hidden_case.size == 0 ? 2 : 3;
  }
  if (one.hidden_case.group == "pair") {
    return 5;
  }
  return one.hidden_case.plan.hidden.count("dropout") > 0 ? 7 : 6;
}

}  // namespace

std::vector<Case> cases(std::size_t count, std::uint64_t seed) {
  std::vector<std::function<Case(std::uint64_t)>> all = recipes();
  std::mt19937_64 random(seed);
  std::vector<Case> out;
  while (out.size() < count) {
    // Every round contains every recipe once, in another order, so that a short run is a fair sample.
    for (std::size_t k = all.size(); k-- > 1;) {
      std::swap(all[k], all[static_cast<std::size_t>(random() % (k + 1))]);
    }
    for (std::size_t k = 0; k < all.size() && out.size() < count; ++k) {
      out.push_back(all[k](random() >> 16));
    }
  }
  return out;
}

Outcome analyse(const Case& hidden_case) {
  Outcome out;
  out.hidden_case = hidden_case;
  try {
    const logs::FlightLog log = fly(hidden_case.plan);
    identify::Request request;
    request.axis = hidden_case.plan.axis;
    request.declared = hidden_case.declare;
    request.train = {{3.0, 30.0}};
    request.validate = {{30.0, 44.0}};
    request.log = &log;
    request.validation_log = &log;
    request.refits = 0;
    const identify::IdentifyResult result =
        request.axis == "translation" ? identify::identify_translation(request) : identify::identify_axis(request);
    for (const identify::EffectResult& effect : result.effects) {
      out.found.push_back(effect.name);
    }
    out.not_separable = result.not_separable;
    out.unexplained = result.unexplained;
    out.verdict = result.verdict;
    out.before = result.declared.validation_rmse;
    out.after = result.final_model.validation_rmse;
    out.elapsed_s = result.elapsed_s;
  } catch (const std::exception& error) {
    out.failure = error.what();
  }
  out.right = matches(out, false);
  out.among_two = matches(out, true);
  return out;
}

std::vector<Outcome> analyse_all(const std::vector<Case>& list, unsigned threads,
                                 const std::function<void(const Outcome&, std::size_t)>& done) {
  std::vector<Outcome> out(list.size());
  std::atomic<std::size_t> next{0};
  std::size_t finished = 0;
  std::mutex telling;
  const auto work = [&] {
    for (std::size_t k = next++; k < list.size(); k = next++) {
      out[k] = analyse(list[k]);
      const std::lock_guard<std::mutex> lock(telling);
      done(out[k], ++finished);
    }
  };
  std::vector<std::thread> pool;
  for (unsigned k = 0; k < std::max(1U, threads); ++k) {
    pool.emplace_back(work);
  }
  for (std::thread& one : pool) {
    one.join();
  }
  return out;
}

std::vector<Score> scores(const std::vector<Outcome>& outcomes) {
  std::vector<Score> out{{"nothing hidden, nothing named", 0, 0, 0.98},
                         {"single effects, medium", 0, 0, 0.95},
                         {"single effects, small", 0, 0, 0.0},
                         {"single effects, large", 0, 0, 0.0},
                         {"single effects, among the first two", 0, 0, 0.97},
                         {"pairs", 0, 0, 0.90},
                         {"outside the library: unexplained", 0, 0, 0.95},
                         {"command dropout: unexplained", 0, 0, 0.70}};
  const auto add = [&](std::size_t k, bool right) {
    out[k].count += 1;
    out[k].right += right ? 1 : 0;
  };
  for (const Outcome& one : outcomes) {
    add(row_of(one), one.right);
    if (one.hidden_case.group == "single" && one.hidden_case.size >= 1) {
      add(4, one.among_two);
    }
  }
  return out;
}

plot::HeatMap matrix_of(const std::vector<Outcome>& outcomes) {
  plot::HeatMap matrix{.title = "Hidden (rows) and named (columns); simulated logs",
                       .bad = -1.0,
                       .good_words = "all of the row, and right",
                       .bad_words = "all of the row, and wrong"};
  const auto index = [](Names& names, const std::string& name) {
    const auto found = std::find(names.begin(), names.end(), name);
    if (found != names.end()) {
      return static_cast<std::size_t>(found - names.begin());
    }
    names.push_back(name);
    return names.size() - 1;
  };
  Names all{"nothing"};
  all.insert(all.end(), kRoll.begin(), kRoll.end());
  all.insert(all.end(), kTranslation.begin(), kTranslation.end());
  all.insert(all.end(), kThrust.begin(), kThrust.end());
  matrix.columns = all;
  matrix.columns.emplace_back("unexplained");
  matrix.rows = all;
  for (const char* name : {"sine", "dropout", "product", "slung_load"}) {
    matrix.rows.emplace_back(name);
  }
  std::map<std::pair<std::size_t, std::size_t>, int> counts;
  for (const Outcome& one : outcomes) {
    if (one.hidden_case.plan.hidden.size() > 1) {
      continue;
    }
    const std::string row =
        one.hidden_case.plan.hidden.empty() ? "nothing" : one.hidden_case.plan.hidden.begin()->first;
    const std::string column = one.verdict == "unexplained" ? "unexplained"
                               : one.found.empty()          ? "nothing"
                                                            : one.found.front();
    ++counts[{index(matrix.rows, row), index(matrix.columns, column)}];
  }
  matrix.values.assign(matrix.rows.size(), std::vector<double>(matrix.columns.size(), std::nan("")));
  matrix.words.assign(matrix.rows.size(), std::vector<std::string>(matrix.columns.size()));
  std::map<std::size_t, int> totals;
  for (const auto& [at, count] : counts) {
    totals[at.first] += count;
  }
  for (const auto& [at, count] : counts) {
    const bool is_outside = at.first >= all.size();
    const Names right = is_outside ? Names{"unexplained"} : counting_for(matrix.rows[at.first]);
    const double sign = contains(right, matrix.columns[at.second]) ? 1.0 : -1.0;
    matrix.values[at.first][at.second] = sign * count / totals[at.first];
    matrix.words[at.first][at.second] = std::to_string(count);
  }
  return matrix;
}

}  // namespace m100::lab::hidden
