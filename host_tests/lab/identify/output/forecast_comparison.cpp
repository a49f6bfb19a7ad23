// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/output/forecast_comparison.h"

#include <algorithm>
#include <vector>

#include "firmware/model/axis_effects.h"
#include "host_tests/lab/printed.h"

namespace m100::lab::identify {
namespace {

constexpr double kSigmasOfInterval = 2.0 * 1.96;

bool is_named(const std::string& effect, const IdentifyResult& result) {
  const std::vector<std::string>& structure = result.final_model.structure;
  return std::find(structure.begin(), structure.end(), effect) != structure.end();
}

/// Standard deviation of the effect's first parameter; negative: none was found.
double found_deviation(const std::string& effect, const IdentifyResult& result) {
  const model::AxisEffect* const row = model::axis_effect(effect);
  for (const NamedInterval& one : result.final_intervals) {
    if (row != nullptr && row->numbers.size() > 0 && one.name == row->numbers[0].parameter) {
      return (one.interval.high - one.interval.low) / kSigmasOfInterval;
    }
  }
  return -1.0;
}

const Json* forecast_of(const Json& all, const std::string& axis) {
  const Json* one = &all;
  if (all.contains("axes") && all["axes"].contains(axis)) {
    one = &all["axes"][axis];
  }
  return one->value("axis", "") == axis && one->contains("forecast") ? one : nullptr;
}

std::string listed(const Json& names) {
  std::string out;
  for (const Json& name : names) {
    out += (out.empty() ? "" : ", ") + name.get<std::string>();
  }
  return out.empty() ? "none" : out;
}

}  // namespace

Json compare_with_forecast(const Json& forecast, const IdentifyResult& result) {
  const Json* const of_axis = forecast_of(forecast, result.axis);
  if (of_axis == nullptr) {
    return {};
  }
  Json effects = Json::array();
  Json kept = Json::array(), beyond = Json::array(), absent = Json::array();
  for (const Json& one : (*of_axis)["forecast"]) {
    const std::string effect = one.value("effect", "");
    const bool enough = one.value("enough", false);
    const bool named = is_named(effect, result);
    const double apart = one.value("apart_sigma", 0.0);
    Json row{{"effect", effect}, {"enough", enough}, {"named", named}};
    if (apart > 0.0) {
      row["forecast_deviation"] = one.value("size", 0.0) / apart;
    }
    if (const double found = found_deviation(effect, result); named && found >= 0.0) {
      row["found_deviation"] = found;
    }
    row["most_alike"] = one.value("most_alike", "");
    row["likeness"] = one.value("likeness", 0.0);
    effects.push_back(std::move(row));
    if (named) {
      (enough ? kept : beyond).push_back(effect);
    } else if (enough) {
      absent.push_back(effect);
    }
  }
  return {{"as_forecast", kept}, {"beyond_forecast", beyond}, {"would_have_shown", absent}, {"effects", effects}};
}

std::string forecast_sentence(const Json& comparison) {
  std::string out =
      "Effects that the excitation was designed to show and that were found: " + listed(comparison["as_forecast"]) +
      "; effects that it would have shown but that were not found: " + listed(comparison["would_have_shown"]) + ".";
  for (const Json& row : comparison["effects"]) {
    if (row["named"] == true && row["enough"] == false) {
      out += " " + row["effect"].get<std::string>() + " was found although the forecast could not tell it from " +
             row["most_alike"].get<std::string>() + ".";
    }
    if (row.contains("found_deviation") && row.contains("forecast_deviation")) {
      out += printed(" %s is known to a standard deviation of %.3g; the forecast was %.3g.",
                     row["effect"].get<std::string>().c_str(), row["found_deviation"].get<double>(),
                     row["forecast_deviation"].get<double>());
    }
  }
  return out;
}

}  // namespace m100::lab::identify
