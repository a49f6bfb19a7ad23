// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/fly/monitor/thread_accounting.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <charconv>

namespace m100::companion {

ThreadAccounting::ThreadAccounting()
    : schedstat_(open("/proc/thread-self/schedstat", O_RDONLY | O_CLOEXEC)), last_(total()) {}

ThreadCounts ThreadAccounting::update() {
  const ThreadCounts now = total();
  const ThreadCounts since{.without_processor = now.without_processor - last_.without_processor,
                           .disk_faults = now.disk_faults - last_.disk_faults};
  last_ = now;
  return since;
}

ThreadCounts ThreadAccounting::total() const {
  ThreadCounts counts;
  std::array<char, 96> text{};
  const ssize_t size = schedstat_.number >= 0 ? pread(schedstat_.number, text.data(), text.size(), 0) : 0;
  if (size > 0) {
    counts.without_processor = run_queue_time({text.data(), static_cast<std::size_t>(size)});
  }
  rusage usage{};
  if (getrusage(RUSAGE_THREAD, &usage) == 0) {
    counts.disk_faults = static_cast<std::uint64_t>(usage.ru_majflt);
  }
  return counts;
}

core::Duration run_queue_time(std::string_view schedstat) {
  const std::size_t space = schedstat.find(' ');
  std::int64_t time_ns = 0;
  if (space != std::string_view::npos) {
    (void)std::from_chars(schedstat.data() + space + 1, schedstat.data() + schedstat.size(), time_ns);
  }
  return std::chrono::duration_cast<core::Duration>(std::chrono::nanoseconds(time_ns));
}

TextLine describe(core::Duration stall, const ThreadCounts& counts) {
  TextLine line;
  line.add("this program stood still for ").add(core::seconds<double>(stall), 3);
  line.add(" s: ready to run but without a processor for ").add(core::seconds<double>(counts.without_processor), 3);
  return line.add(" s, page faults from the disk: ").add(static_cast<double>(counts.disk_faults), 0);
}

}  // namespace m100::companion
