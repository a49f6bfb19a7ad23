// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/operator/line_writer.h"

#include <malloc.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <iostream>
#include <string>

#include "firmware/companion/operator/live_display.h"

namespace m100::companion {
namespace {

constexpr auto kLook = std::chrono::milliseconds(10);
constexpr std::string_view kBegin = "\r\x1b[K";  ///< cursor to the left end, line erased
constexpr std::size_t kNoEnd = 1000;             ///< columns if the output is not a terminal
std::atomic<LineWriter*> the_current{nullptr};

/// Columns that a line may have: one less than the terminal, because a longer line could not be erased.
std::size_t columns() {
  winsize size{};
  return ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1 ? size.ws_col - 1U : kNoEnd;
}

/// @param former counts of a second before
std::string status_line(const app::TickRecord<double>& record, const link::PoseLinkStats& former) {
  const auto lost = static_cast<double>(std::uint64_t{record.poses.lost_frames} - former.lost_frames);
  const auto came = static_cast<double>(record.poses.poses - former.poses);
  return std::string(kBegin) + status_of(record, lost / std::max(1.0, lost + came)).substr(0, columns());
}

}  // namespace

LineWriter* LineWriter::current() { return the_current; }

LineWriter::LineWriter(bool has_status, Write write, std::chrono::milliseconds patience)
    : has_status_(has_status), patience_(patience), shared_(std::make_shared<Shared>()) {
  std::cout << std::flush;        // what was printed before
  (void)mallopt(M_ARENA_MAX, 1);  // an arena of the thread's own would be 64 MB of locked memory
  thread_ = std::thread([shared = shared_, write, has_status] {
    while (shared->runs) {
      write_all(*shared, write);
      std::this_thread::sleep_for(kLook);
    }
    write_all(*shared, write);
    if (has_status) {
      write(STDOUT_FILENO, kBegin);
    }
    shared->ended = true;
  });
  the_current = this;
}

void LineWriter::write_all(Shared& shared, Write write) {
  TextLine line;
  while (shared.lines.pop(line)) {
    write(STDOUT_FILENO, line.text());
  }
  app::TickRecord<double> record;
  while (shared.records.pop(record)) {
    link::PoseLinkStats& former = shared.former[shared.shown++ % shared.former.size()];
    write(STDOUT_FILENO, status_line(record, former));
    former = record.poses;
  }
}

void LineWriter::push(std::string_view line) {
  constexpr std::size_t kEnd = 1;
  TextLine whole;
  whole.add(has_status_ ? kBegin : "");
  (void)shared_->lines.push(whole.add(line.substr(0, TextLine::kMaxBytes - kEnd - whole.text().size())).add("\n"));
}

void LineWriter::finish() {
  if (!thread_.joinable()) {
    return;
  }
  the_current = nullptr;
  shared_->runs = false;
  const auto until = std::chrono::steady_clock::now() + patience_;
  while (!shared_->ended && std::chrono::steady_clock::now() < until) {
    std::this_thread::sleep_for(kLook);
  }
  shared_->ended ? thread_.join() : thread_.detach();
}

}  // namespace m100::companion
