// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "host_tests/lab/input_error.h"
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

/// A file of one test.
class TemporaryFile {
 public:
  TemporaryFile(const std::string& name, const std::string& content)
      : path_(std::filesystem::temp_directory_path() / ("m100_" + test_name() + "_" + name)) {
    std::ofstream(path_, std::ios::binary) << content;
  }
  std::string path() const { return path_.string(); }

 private:
  static std::string test_name() {
    const ::testing::TestInfo& test = *::testing::UnitTest::GetInstance()->current_test_info();
    std::string name = std::string(test.test_suite_name()) + test.name();
    std::replace(name.begin(), name.end(), '/', '_');
    return name;
  }

  std::filesystem::path path_;
};

/// @returns the error message of `act`; the test fails if there is none.
template <typename Act>
std::string complaint_of(Act&& act) {
  try {
    act();
  } catch (const InputError& error) {
    return error.what();
  }
  ADD_FAILURE() << "accepted";
  return "";
}

}  // namespace m100::lab::logs
