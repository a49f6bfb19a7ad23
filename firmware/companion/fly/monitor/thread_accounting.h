// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string_view>

#include "firmware/companion/operator/text_line.h"
#include "firmware/core/time.h"
#include "hal/linux/descriptor.h"

namespace m100::companion {

/// What the kernel counted of a thread in a period.
struct ThreadCounts {
  core::Duration without_processor{0};  ///< ready to run, in the run queue
  std::uint64_t disk_faults = 0;        ///< page faults that waited for the disk
};

/// Reads what the kernel counts of a thread (schedstat, getrusage); this thread must construct and call it. Neither
/// call waits for a lock that a thread of normal priority may hold. No heap.
class ThreadAccounting {
 public:
  ThreadAccounting();

  /// @returns the counts since the last call, or since the construction.
  ThreadCounts update();

 private:
  ThreadCounts total() const;

  hal::Descriptor schedstat_;  ///< none: this kernel does not count
  ThreadCounts last_;
};

/// The waiting time in a thread's schedstat: the second of three numbers, nanoseconds. Zero if there is none.
core::Duration run_queue_time(std::string_view schedstat);

/// The cause of a stall in words.
TextLine describe(core::Duration stall, const ThreadCounts& counts);

}  // namespace m100::companion
