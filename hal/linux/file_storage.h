// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "hal/linux/descriptor.h"
#include "hal/linux/system_calls.h"
#include "hal/storage.h"

namespace m100::hal {

/// A file that is only appended to. An existing file is refused, not overwritten: a flight is flown once.
class FileStorage final : public Storage {
 public:
  explicit FileStorage(std::string path, const SystemCalls& calls = real_system_calls());

  /// @returns kOk; kRefused: exists already, or no right to write there; kUnavailable: anything else.
  core::Status open();
  core::Expected<std::size_t> append(std::span<const std::byte> source) override;
  core::Status sync() override;
  const std::string& path() const { return path_; }
  /// errno of the open(), append() or sync() that failed last; 0: none has.
  int last_error() const { return last_error_; }

 private:
  std::string path_;
  const SystemCalls* calls_;
  Descriptor descriptor_;
  int last_error_ = 0;
};

}  // namespace m100::hal
