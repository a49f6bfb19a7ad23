// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>

namespace m100::core {

/// Why something was not done. kOk is the only good one.
enum class [[nodiscard]] Status : unsigned char{
    kOk,
    kNotReady,           ///< nothing to report yet; call again with more data or later
    kOutOfRange,         ///< a number is not finite or outside its stated range
    kInvalidArgument,    ///< the request makes no sense as written
    kDataLoss,           ///< a checksum failed; the data are gone
    kResourceExhausted,  ///< a fixed capacity is full
    kTimeout,            ///< no answer in time, all tries used
    kRefused,            ///< the other side said no, or an earlier rule forbids it
    kUnavailable,        ///< the device or the link is gone
    kNotConverged,       ///< a bounded iteration met its cap
};

/// The enumerator's name without the k, for logs and messages.
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
