// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/output/result_text.h"
#include "host_tests/lab/printed.h"

#include <cstdarg>
#include <cstdio>

namespace m100::lab::identify {
namespace {

Json to_json(const Interval& interval) {
  return {{"value", interval.value}, {"low", interval.low}, {"high", interval.high}};
}

std::string horizon_key(double age_s) { return printed("%.1f", age_s); }

Json to_json(const HorizonErrors& errors) {
  Json out = Json::object();
  for (std::size_t k = 0; k < errors.size(); ++k) {
    out[horizon_key(kHorizons_s[k])] = errors[k];
  }
  return out;
}

Json to_json(const ModelResult& model) {
  Json parameters = Json::object();
  for (const NamedValue& parameter : model.parameters) {
    parameters[parameter.name] = parameter.value;
  }
  if (!model.dead_zone_shape.empty()) {
    parameters["shape"] = model.dead_zone_shape;
  }
  Json out{{"structure", model.structure},     {"parameters", std::move(parameters)},
           {"train_rmse", model.train_rmse},   {"validation_rmse", model.validation_rmse},
           {"fit_percent", model.fit_percent}, {"horizon_rmse", to_json(model.horizon_rmse)}};
  if (model.position_rmse.front() > 0.0) {
    out["position_rmse"] = to_json(model.position_rmse);
    out["velocity_rmse"] = to_json(model.velocity_rmse);
  }
  return out;
}

Json to_json(const EffectResult& effect) {
  Json parameters = Json::object();
  for (const NamedInterval& parameter : effect.parameters) {
    parameters[parameter.name] = to_json(parameter.interval);
  }
  if (!effect.shape.empty()) {
    parameters["shape"] = effect.shape;
  }
  Json rivals = Json::array();
  for (const Rival& rival : effect.rivals) {
    rivals.push_back({{"name", rival.name}, {"validation_rmse", rival.validation_rmse}, {"cv_ratio", rival.cv_ratio}});
  }
  return {{"name", effect.name},
          {"parameters", std::move(parameters)},
          {"validation_rmse_after", effect.validation_rmse_after},
          {"cv_gain", effect.cv_gain},
          {"delta_bic", effect.delta_bic},
          {"paired_t", effect.paired_t},
          {"rivals", std::move(rivals)}};
}

Json findings_of(const IdentifyResult& result) {
  Json out = Json::array();
  for (const Finding& finding : result.findings) {
    Json one{{"what", finding.what}, {"signal", finding.signal}};
    one["from_s"] = finding.from_s;
    one["to_s"] = finding.to_s;
    if (!finding.certain) {
      one["certain"] = false;
    }
    one["text"] = finding.text;
    out.push_back(std::move(one));
  }
  return out;
}

Json change_points(const IdentifyResult& result) {
  Json out = Json::array();
  for (const Change& change : result.changes) {
    Json parameters = Json::object();
    for (const NamedValue& parameter : change.parameters) {
      parameters[parameter.name] = parameter.value;
    }
    Json one{{"at_s", change.at_s},
             {"low", change.low_s},
             {"high", change.high_s},
             {"name", change.name},
             {"parameters", std::move(parameters)},
             {"rivals", change.rivals},
             {"likelihood_ratio", change.likelihood_ratio}};
    if (change.size) {
      one["size"] = {{"value", change.size->value}, {"low", change.size->low}, {"high", change.size->high}};
    }
    out.push_back(std::move(one));
  }
  return out;
}

Json remainder_of(const IdentifyResult& result) {
  Json out = Json::array();
  for (const RemainderCurve& curve : result.remainder) {
    Json one{{"channel", curve.channel},        {"unit", curve.unit},
             {"direction", curve.direction},    {"curve", curve.is_gain ? "gain" : "added"},
             {"predicted", curve.predicted},    {"chance", curve.chance},
             {"after_first", curve.after_first}};
    if (!curve.x.empty()) {
      one["x"] = curve.x;
      one["value"] = curve.value;
      one["low"] = curve.low;
      one["high"] = curve.high;
    }
    out.push_back(std::move(one));
  }
  return out;
}

class Text {
 public:
  [[gnu::format(printf, 2, 3)]] void line(const char* format, ...) {
    char buffer[400];
    va_list arguments;
    va_start(arguments, format);
    std::vsnprintf(buffer, sizeof buffer, format, arguments);
    va_end(arguments);
    out_ += buffer;
    out_ += '\n';
  }
  std::string take() { return std::move(out_); }

 private:
  std::string out_;
};

const char* unit_of(const std::string& axis) {
  return axis == "climb" ? "m/s" : axis == "yaw_rate" ? "rad/s" : axis == "translation" ? "m/s^2" : "rad";
}

/// A parameter's name with the unit of the axis' input where that is a command: "width_rad" instead of "width_counts".
std::string in_stick_unit(std::string name, const IdentifyResult& result) {
  constexpr std::string_view kCounts = "counts";
  if (name.ends_with(kCounts)) {
    name.replace(name.size() - kCounts.size(), kCounts.size(), result.stick_unit);
  }
  return name;
}

std::string joined(const std::vector<std::string>& names, const char* between) {
  std::string out;
  for (const std::string& name : names) {
    out += (out.empty() ? "" : between) + name;
  }
  return out;
}

}  // namespace

Json to_json(const IdentifyResult& result) {
  Json effects = Json::array();
  for (const EffectResult& effect : result.effects) {
    effects.push_back(to_json(effect));
  }
  Json intervals = Json::object();
  for (const NamedInterval& parameter : result.final_intervals) {
    intervals[parameter.name] = to_json(parameter.interval);
  }
  Json final_model = to_json(result.final_model);
  final_model["intervals"] = std::move(intervals);
  Json candidates = Json::array();
  for (const CandidateRow& row : result.candidates) {
    candidates.push_back({{"round", row.round},
                          {"name", row.name},
                          {"cv_gain", row.cv_gain},
                          {"delta_bic", row.delta_bic},
                          {"delta_white", row.delta_white},
                          {"paired_t", row.paired_t},
                          {"big_enough", row.is_significant},
                          {"accepted", row.accepted},
                          {"winner", row.winner}});
  }
  return {{"axis", result.axis},
          {"declared", to_json(result.declared)},
          {"effects", std::move(effects)},
          {"final", std::move(final_model)},
          {"noise_floor", result.noise_floor},
          {"alignment",
           {{"stick_shift_samples", result.alignment.stick_shift_samples}, {"evidence", result.alignment.evidence}}},
          {"not_separable", result.not_separable},
          {"unexplained", result.unexplained},
          {"verdict", result.verdict},
          {"findings", findings_of(result)},
          {"changes", change_points(result)},
          {"refitted", to_json(result.refitted)},
          {"remainder", remainder_of(result)},
          {"validation_over_training", result.validation_over_training},
          {"candidates", std::move(candidates)},
          {"elapsed_s", result.elapsed_s}};
}

Json to_json(const std::vector<Refitted>& refitted) {
  Json out = Json::array();
  for (const Refitted& one : refitted) {
    out.push_back({{"parameter", one.parameter},
                   {"believed", one.believed},
                   {"found", one.found.value},
                   {"low", one.found.low},
                   {"high", one.found.high},
                   {"matters", one.matters}});
  }
  return out;
}

namespace {

void effect_lines(const IdentifyResult& result, Text& text) {
  for (const EffectResult& effect : result.effects) {
    text.line("  found %s%s: validation error with it %.5f; cross-validated gain %.1f %%, criterion %.1f, t %.1f",
              effect.name.c_str(), effect.shape.empty() ? "" : (" (" + effect.shape + ")").c_str(),
              effect.validation_rmse_after, 100.0 * effect.cv_gain, effect.delta_bic, effect.paired_t);
    for (const Rival& rival : effect.rivals) {
      text.line("    not separable from %s (validation error %.5f)", rival.name.c_str(), rival.validation_rmse);
    }
  }
}

void change_lines(const IdentifyResult& result, Text& text) {
  for (const Change& change : result.changes) {
    text.line("  changed at %.1f s [%.1f, %.1f]: %s%s", change.at_s, change.low_s, change.high_s, change.name.c_str(),
              change.rivals.empty() ? "" : (" (or " + joined(change.rivals, ", ") + ")").c_str());
    for (const NamedValue& parameter : change.parameters) {
      text.line("    %-24s %12.6g", in_stick_unit(parameter.name, result).c_str(), parameter.value);
    }
    if (change.size) {
      text.line("    %-24s %12.6g [%.6g, %.6g]", "difference", change.size->value, change.size->low, change.size->high);
    }
  }
}

void believed_lines(const IdentifyResult& result, Text& text) {
  for (const Refitted& one : result.refitted) {
    text.line("  %-26s believed %.6g, found %.6g [%.6g, %.6g]%s", one.parameter.c_str(), one.believed, one.found.value,
              one.found.low, one.found.high, one.matters ? ": matters" : "");
  }
}

}  // namespace

std::string to_text(const IdentifyResult& result) {
  Text text;
  const char* unit = unit_of(result.axis);
  text.line("%s: simulation error over 2.5 s blocks, root mean square in %s", result.axis.c_str(), unit);
  text.line("  %-10s %-46s %10s %10s %8s", "", "structure", "training", "validation", "fit");
  for (const auto& [name, model] : {std::pair{"declared", &result.declared}, std::pair{"final", &result.final_model}}) {
    text.line("  %-10s %-46s %10.5f %10.5f %6.1f %%", name, joined(model->structure, " + ").c_str(), model->train_rmse,
              model->validation_rmse, model->fit_percent);
  }
  effect_lines(result, text);
  for (const NamedInterval& parameter : result.final_intervals) {
    text.line("  %-26s %12.6g   [%.6g, %.6g]", in_stick_unit(parameter.name, result).c_str(), parameter.interval.value,
              parameter.interval.low, parameter.interval.high);
  }
  text.line("  validation error over training error: %.2f", result.validation_over_training);
  const auto horizons = [&](const char* what, HorizonErrors ModelResult::*errors) {
    for (std::size_t k = 0; k < kHorizons_s.size(); ++k) {
      text.line("  %s after %.1f s: %.5f declared, %.5f final", what, kHorizons_s[k], (result.declared.*errors)[k],
                (result.final_model.*errors)[k]);
    }
  };
  horizons("prediction error", &ModelResult::horizon_rmse);
  if (result.final_model.position_rmse.front() > 0.0) {
    horizons("position from the sticks [m]", &ModelResult::position_rmse);
    horizons("velocity from the sticks [m/s]", &ModelResult::velocity_rmse);
  }
  change_lines(result, text);
  believed_lines(result, text);
  for (const Finding& finding : result.findings) {
    text.line("  %s: %s", finding.certain ? finding.what.c_str() : (finding.what + " (not certain)").c_str(),
              finding.text.c_str());
  }
  for (const std::string& left : result.unexplained) {
    text.line("  unexplained: %s", left.c_str());
  }
  text.line("  verdict: %s (%.2f s)", result.verdict.c_str(), result.elapsed_s);
  return text.take();
}

}  // namespace m100::lab::identify
