// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "host_tests/lab/hidden/hidden_flight.h"
#include "host_tests/lab/identify/output/result.h"
#include "host_tests/lab/identify/request.h"

namespace m100::lab::identify {

/// A log of "roll" or "translation" with nothing hidden.
inline logs::FlightLog healthy_flight(const std::string& axis, std::uint64_t seed) {
  hidden::FlightPlan plan;
  plan.axis = axis;
  plan.seed = seed;
  return hidden::fly(plan);
}

/// A request about two parts of one log, without intervals.
inline Request about(const logs::FlightLog& log, const std::string& axis, const std::vector<std::string>& declared,
                     Range train = {3.0, 30.0}, Range validate = {30.0, 44.0}) {
  Request request;
  request.axis = axis;
  request.declared = declared;
  request.train = {train};
  request.validate = {validate};
  request.log = request.validation_log = &log;
  request.refits = 0;
  return request;
}

/// The verdict and everything beside the numbers in one line, for messages of tests and to search in.
inline std::string text_of(const IdentifyResult& result, bool with_notes = true) {
  std::string out = result.verdict + ";";
  for (const EffectResult& effect : result.effects) {
    out += " named " + effect.name + ";";
  }
  for (const std::string& text : result.unexplained) {
    out += " " + text + ";";
  }
  for (const Finding& finding : result.findings) {
    out += finding.what == "note" && !with_notes ? "" : " " + finding.what + ": " + finding.text + ";";
  }
  for (const Change& change : result.changes) {
    out += " changed " + change.name + " at " + std::to_string(change.at_s) + ";";
  }
  return out;
}

}  // namespace m100::lab::identify
