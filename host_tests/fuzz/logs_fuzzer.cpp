// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer's entry point for the readers of logs and of column maps. It is one program; the first byte of an input
// chooses the reader.
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "host_tests/lab/input_error.h"
#include "host_tests/lab/logs/column_map.h"
#include "host_tests/lab/logs/formats/ardupilot.h"
#include "host_tests/lab/logs/formats/csv.h"
#include "host_tests/lab/logs/formats/mat.h"
#include "host_tests/lab/logs/formats/rosbag.h"
#include "host_tests/lab/logs/formats/rosbag2.h"
#include "host_tests/lab/logs/formats/ulog.h"
#include "host_tests/lab/logs/proposal/propose.h"
#include "host_tests/lab/logs/raw_log.h"

namespace {

using namespace m100::lab;

/// A file in memory, rewritten for every input.
const std::string& as_file(std::string_view bytes) {
  static const int file = memfd_create("log", 0);
  static const std::string path = "/proc/self/fd/" + std::to_string(file);
  const bool written =
      ftruncate(file, 0) == 0 && pwrite(file, bytes.data(), bytes.size(), 0) == static_cast<ssize_t>(bytes.size());
  if (!written) {
    std::abort();
  }
  return path;
}

std::unique_ptr<logs::RawLog> open_as(unsigned reader, const std::string& path) {
  switch (reader) {
    case 0:
      return logs::open_csv(path);
    case 1:
      return logs::open_mat(path);
    case 2:
      return logs::open_ulog(path);
    case 3:
      return logs::open_ardupilot(path);
    case 4:
      return logs::open_rosbag(path);
    case 5:
      return logs::open_rosbag2(path);
    default:
      return logs::open_log(path);
  }
}

void ask_everything(const logs::RawLog& log) {
  static_cast<void>(log.topics());
  static_cast<void>(log.notes());
  static_cast<void>(logs::propose(log));
  const std::vector<std::string> names = log.names();
  if (names.size() > logs::RawLog::kMaxNames) {
    std::abort();
  }
  for (std::size_t k = 0; k < std::min<std::size_t>(names.size(), 8); ++k) {
    try {
      static_cast<void>(log.column(names[k], "fuzzer"));
    } catch (const InputError&) {
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) {
    return 0;
  }
  const std::string_view bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  constexpr unsigned kReaders = 8;
  const unsigned reader = data[0] % kReaders;
  try {
    if (reader == kReaders - 1) {
      static_cast<void>(logs::parse_column_map(bytes, "map"));
    } else {
      ask_everything(*open_as(reader, as_file(bytes)));
    }
  } catch (const InputError&) {
  }
  return 0;
}
