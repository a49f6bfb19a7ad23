// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string_view>

namespace m100::model {

/// Which part handles an effect in flight, once it has been identified.
enum class InFlight : std::uint8_t {
  kInvertedAtTheStick,  ///< the stick map inverts it
  kInThePrediction,     ///< the estimator and the controller's model contain it
  kLeftToTheObserver,   ///< it appears as a disturbance, which the observer estimates
  kNowhere,             ///< it belongs to the log or to another loop: the horizontal controller does not handle it
};

/// The part that handles an effect, as words that end a sentence of a report.
constexpr std::string_view words(InFlight who) {
  switch (who) {
    case InFlight::kInvertedAtTheStick:
      return "inverted at the stick";
    case InFlight::kInThePrediction:
      return "in the prediction";
    case InFlight::kLeftToTheObserver:
      return "left to the observer";
    case InFlight::kNowhere:
      break;
  }
  return "not taken care of by the horizontal controller";
}

}  // namespace m100::model
