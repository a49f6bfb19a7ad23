// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "host_tests/lab/hidden/hidden_flight.h"
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

}  // namespace m100::lab::identify
