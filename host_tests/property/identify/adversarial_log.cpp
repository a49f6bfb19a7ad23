// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/property/identify/adversarial_log.h"

#include <algorithm>
#include <cmath>

#include "host_tests/lab/identify/axis_pipeline.h"
#include "host_tests/lab/identify/request.h"

namespace m100::host_tests {
namespace {

/// Whether the answer says that these data cannot separate the two effects.
bool stands_for(const lab::identify::IdentifyResult& result, const std::string& one, const std::string& other) {
  const auto holds = [](const std::vector<std::string>& group, const std::string& name) {
    return std::find(group.begin(), group.end(), name) != group.end();
  };
  return !other.empty() && std::any_of(result.not_separable.begin(), result.not_separable.end(),
                                       [&](const auto& group) { return holds(group, one) && holds(group, other); });
}

/// Whether an effect is named that is not there.
bool names_another(const AdversarialLog& truth, const lab::identify::IdentifyResult& result) {
  return std::any_of(result.effects.begin(), result.effects.end(), [&](const auto& effect) {
    return std::find(truth.named.begin(), truth.named.end(), effect.name) == truth.named.end() &&
           !(effect.name == truth.effect || stands_for(result, effect.name, truth.effect));
  });
}

/// Whether the change is named, near its time.
bool names_change(const AdversarialLog& truth, const lab::identify::IdentifyResult& result) {
  return std::any_of(result.changes.begin(), result.changes.end(), [&](const auto& one) {
    return one.name == truth.change && std::abs(one.at_s - truth.change_s) < 3.0;
  });
}

}  // namespace

lab::identify::IdentifyResult identify_log(const AdversarialLog& truth, std::size_t refits) {
  lab::identify::Request request;
  request.axis = truth.axis;
  request.declared = truth.declared;
  request.train = truth.train;
  request.validate = truth.validate;
  request.log = request.validation_log = &truth.log;
  request.refits = refits;
  return lab::identify::identify_axis(request);
}

namespace {

Classification judge_of_healthy(const std::string& verdict) {
  if (verdict == "nothing_missing") {
    return Classification::kRight;
  }
  return verdict == "unexplained" ? Classification::kFalseRejection : Classification::kWrongName;
}

}  // namespace

Classification classify(const AdversarialLog& truth, const lab::identify::IdentifyResult& result) {
  if (truth.healthy) {
    return judge_of_healthy(result.verdict);
  }
  const bool said = std::any_of(result.findings.begin(), result.findings.end(),
                                [&](const auto& finding) { return finding.what == truth.finding && finding.certain; });
  if (result.verdict == "nothing_missing") {
    return truth.usable && (said || truth.finding == "note") ? Classification::kRight
                                                             : Classification::kFalseAcceptance;
  }
  const bool named = truth.effect.empty() ? said : !result.effects.empty();
  const bool hit = truth.change.empty() ? named && result.changes.empty() : names_change(truth, result);
  if (hit && !names_another(truth, result)) {
    return Classification::kRight;
  }
  return result.verdict == "unexplained" ? Classification::kUndecided : Classification::kWrongName;
}

}  // namespace m100::host_tests
