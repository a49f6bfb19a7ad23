// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/operator/line_writer.h"

#include <malloc.h>
#include <unistd.h>

#include <iostream>

namespace m100::companion {
namespace {

constexpr auto kLook = std::chrono::milliseconds(10);
std::atomic<LineWriter*> the_current{nullptr};

}  // namespace

LineWriter* LineWriter::current() { return the_current; }

LineWriter::LineWriter(Write write, std::chrono::milliseconds patience)
    : patience_(patience), shared_(std::make_shared<Shared>()) {
  std::cout << std::flush;        // what was printed before
  (void)mallopt(M_ARENA_MAX, 1);  // an arena of the thread's own would be 64 MB of locked memory
  thread_ = std::thread([shared = shared_, write] {
    while (shared->runs) {
      write_all(*shared, write);
      std::this_thread::sleep_for(kLook);
    }
    write_all(*shared, write);
    shared->ended = true;
  });
  the_current = this;
}

void LineWriter::write_all(Shared& shared, Write write) {
  TextLine line;
  while (shared.lines.pop(line)) {
    write(STDOUT_FILENO, line.text());
  }
}

void LineWriter::push(std::string_view line) {
  constexpr std::size_t kEnd = 1;
  TextLine whole;
  (void)shared_->lines.push(whole.add(line.substr(0, TextLine::kMaxBytes - kEnd)).add("\n"));
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
