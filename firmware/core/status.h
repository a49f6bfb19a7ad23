// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>

namespace m100::core {

/// Result of an operation: kOk, or why it was not done.
enum class [[nodiscard]] Status : unsigned char{
    kOk,
    kNotReady,           ///< nothing to report yet; call again with more data or later
    kOutOfRange,         ///< a number is not finite or outside its stated range
    kInvalidArgument,    ///< the request is invalid as written
    kDataLoss,           ///< a checksum failed; the data are gone
    kResourceExhausted,  ///< a fixed capacity is full
    kTimeout,            ///< no answer in time after all retries
    kRefused,            ///< the other side refused, or a rule of ours forbids it
    kUnavailable,        ///< the device or the link is gone
    kNotConverged,       ///< a bounded iteration reached its limit
};

/// The enumerator's name without the k, as words in lower case, for logs and messages.
constexpr std::string_view name(Status status) {
  switch (status) {
    case Status::kOk:
      return "ok";
    case Status::kNotReady:
      return "not ready";
    case Status::kOutOfRange:
      return "out of range";
    case Status::kInvalidArgument:
      return "invalid argument";
    case Status::kDataLoss:
      return "data loss";
    case Status::kResourceExhausted:
      return "resource exhausted";
    case Status::kTimeout:
      return "timeout";
    case Status::kRefused:
      return "refused";
    case Status::kUnavailable:
      return "unavailable";
    case Status::kNotConverged:
      return "not converged";
  }
  return "unknown";
}

}  // namespace m100::core
