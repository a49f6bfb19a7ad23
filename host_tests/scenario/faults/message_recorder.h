// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/companion/operator/operator_log.h"

namespace m100::scenario {

/// Collects the messages to the operator.
class MessageRecorder final : public companion::OperatorLog {
 public:
  void write(core::TimePoint, std::string_view line) override { lines.emplace_back(line); }
  bool has(const std::string& text) const {
    return std::any_of(lines.begin(), lines.end(),
                       [&](const std::string& line) { return line.find(text) != std::string::npos; });
  }
  std::string all() const {
    std::string text;
    for (const std::string& line : lines) {
      text += line + "\n";
    }
    return text;
  }
  std::vector<std::string> lines;
};

}  // namespace m100::scenario
