// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "host_tests/lab/identify/output/result.h"
#include "host_tests/lab/identify/request.h"
#include "host_tests/lab/logs/flight_log.h"

namespace m100::host_tests {

/// A simulated log with known truth that is designed to mislead the identification: one roll axis of 45 s
/// (synthetic_axis.h), or an unknown vehicle's (unseen_log.h).
struct AdversarialLog {
  std::string kind;
  lab::logs::FlightLog log;
  std::string axis = "roll";
  std::vector<std::string> declared{"second_order", "transport_delay"};
  bool healthy = false;            ///< "nothing missing" is the right answer
  std::string change;              ///< effect that changes in mid-flight; empty: none
  double change_s = 0.0;           ///< time of the change
  double change_size = 0.0;        ///< after less before, as a share of before where that is not zero
  std::string finding;             ///< finding about the log that must be reported; empty: none
  std::vector<std::string> named;  ///< effects that may be named
  std::string effect;              ///< effect that the declared model lacks throughout; empty: none
  /// "Nothing missing" is right if the finding is reported: the rest of the log is sound. A change of the air alone
  /// ("note") need not be reported, because the model lacks nothing.
  bool usable = false;
  std::vector<std::pair<double, double>> train{{3.0, 30.0}}, validate{{30.0, 44.0}};
  /// Upper bound of the log's evidence for the hidden effect (unseen_log_bound.h), in up to a second; empty: obvious.
  std::function<double()> evidence;
};

/// The kinds, in the order of the published table.
const std::vector<std::string>& adversarial_log_kinds();
/// @param kind  one of adversarial_log_kinds()
AdversarialLog adversarial_log(const std::string& kind, std::uint64_t seed);

enum class Classification { kRight, kUndecided, kWrongName, kFalseAcceptance, kFalseRejection };

/// Classifies the answer to an adversarial log.
///   right         only the change, the effect or the finding is named; healthy log: nothing missing
///   undecided     "unexplained", and the hidden effect is not named for certain
///   wrong name    "explained" by an effect that is not there
///   false clean   "nothing_missing" although an effect is there
///   refused       a healthy log that does not get "nothing missing"
Classification classify(const AdversarialLog& truth, const lab::identify::IdentifyResult& result);

/// Runs identify with the log's declaration and ranges. @param may_act  as in Request
lab::identify::IdentifyResult identify_log(const AdversarialLog& truth, std::size_t refits = 0,
                                           std::function<bool(lab::identify::SpecialTest)> may_act = {});

}  // namespace m100::host_tests
