// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "host_tests/lab/logs/raw_log.h"

namespace m100::lab::logs {

/// Columns in memory.
class MemoryLog final : public RawLog {
 public:
  explicit MemoryLog(std::map<std::string, RawColumn> columns) : RawLog("made"), columns_(std::move(columns)) {}
  template <typename Values>  // a map of names to values alone
  explicit MemoryLog(const Values& columns) : RawLog("made") {
    for (const auto& [name, values] : columns) {
      columns_[name].values = values;
    }
  }
  RawColumn column(const std::string& name, const std::string&) const override { return columns_.at(name); }
  std::vector<std::string> names() const override {
    std::vector<std::string> out;
    for (const auto& [name, column] : columns_) {
      out.push_back(name);
    }
    return out;
  }

 private:
  std::map<std::string, RawColumn> columns_;
};

}  // namespace m100::lab::logs
