// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/files/signature_times_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <optional>
#include <sstream>

#include "firmware/companion/files/text/printable.h"
#include "firmware/companion/files/text/text_file.h"
#include "firmware/companion/subcommands.h"

namespace m100::companion {
namespace {

constexpr const char* kFirstLine =
    "# Newest MAVLink signatures accepted with this key. Without this file, recorded frames would be accepted again.";

UsageError damaged(const std::string& name, std::size_t line) {
  return UsageError(name + ":" + std::to_string(line) +
                    ": is not what m100 writes; make a new key, or remove the file if nobody recorded earlier flights");
}

bool write_all(int file, const std::string& text) {
  std::size_t done = 0;
  while (done < text.size()) {
    const ssize_t count = ::write(file, text.data() + done, text.size() - done);
    if (count <= 0) {
      return false;
    }
    done += static_cast<std::size_t>(count);
  }
  return ::fsync(file) == 0;
}

struct Line {
  bool is_stream = false;
  mavlink::ReplayStream stream{};  ///< in a "newest" line only the time is set
};

/// @returns nullopt: m100 does not write such a line.
std::optional<Line> read_line(const std::string& line) {
  std::istringstream words(line);
  std::string kind;
  unsigned system = 0, component = 0, link = 0;
  mavlink::SignatureTime time = 0;
  words >> kind;
  if (kind == "stream") {
    words >> system >> component >> link;
  }
  words >> time;
  const bool is_whole = words && (words >> std::ws).eof() && time <= mavlink::kSignatureTimeMask;
  const bool fits = system <= 255 && component <= 255 && link <= 255;
  if (!is_whole || !fits || (kind != "stream" && kind != "newest")) {
    return std::nullopt;
  }
  return Line{.is_stream = kind == "stream",
              .stream = {.from = {static_cast<std::uint8_t>(system), static_cast<std::uint8_t>(component)},
                         .link = static_cast<std::uint8_t>(link),
                         .last = time}};
}

}  // namespace

mavlink::ReplayMemory parse_replay_memory(const std::string& text, const std::string& name) {
  mavlink::ReplayMemory memory;
  std::istringstream lines(text);
  std::string line;
  bool has_newest = false;
  for (std::size_t number = 1; std::getline(lines, line); ++number) {
    if (line.empty() || line.front() == '#') {
      continue;
    }
    const std::optional<Line> read = read_line(line);
    if (!read || memory.count == memory.streams.size() || (!read->is_stream && has_newest)) {
      throw damaged(name, number);
    }
    if (read->is_stream) {
      memory.streams[memory.count++] = read->stream;
    } else {
      memory.newest = read->stream.last;
      has_newest = true;
    }
  }
  if (!has_newest) {
    throw damaged(name, 1);
  }
  return memory;
}

std::string text_of(const mavlink::ReplayMemory& memory, mavlink::SignatureTime ahead) {
  std::ostringstream text;
  text << kFirstLine << "\nnewest " << memory.newest << "\n";
  for (const mavlink::ReplayStream& stream : std::span(memory.streams).first(memory.count)) {
    text << "stream " << unsigned{stream.from.system} << " " << unsigned{stream.from.component} << " "
         << unsigned{stream.link} << " " << std::min(stream.last + ahead, mavlink::kSignatureTimeMask) << "\n";
  }
  return text.str();
}

SignatureTimesFile::SignatureTimesFile(const std::string& key_file) : path_(path_for(key_file)) {
  if (std::filesystem::exists(path_)) {
    accepted_before_ = parse_replay_memory(read_file(path_), path_);
  }
  if (!write(accepted_before_, 0)) {
    throw UsageError(path_ + ": cannot be written: " + why_not_written(errno) + "; it must keep the newest signatures");
  }
}

bool SignatureTimesFile::write(const mavlink::ReplayMemory& memory, mavlink::SignatureTime ahead) {
  const std::string whole = path_ + ".new";
  const int file = ::open(whole.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, S_IRUSR | S_IWUSR);
  if (file < 0) {
    return false;
  }
  const bool written = write_all(file, text_of(memory, ahead));
  const int why = errno;
  ::close(file);
  errno = why;
  return written && std::rename(whole.c_str(), path_.c_str()) == 0;
}

void SignatureTimesFile::start() {
  writer_ = std::thread([this] {
    constexpr auto kLook = std::chrono::milliseconds(20);  // longest delay at the end of the program
    constexpr int kLooksPerWrite = 50;
    mavlink::ReplayMemory memory;
    bool has_news = false;
    for (int look = 0; running_; look = (look + 1) % kLooksPerWrite) {
      while (ring_.pop(memory)) {
        has_news = true;
      }
      if (has_news && look == 0) {
        has_news = !write(memory, kAhead);  // finish() reports it, if it still fails then
      }
      std::this_thread::sleep_for(kLook);
    }
  });
}

void SignatureTimesFile::finish() {
  running_ = false;
  if (writer_.joinable()) {
    writer_.join();
  }
}

void SignatureTimesFile::finish(const mavlink::ReplayMemory& memory) {
  finish();
  if (!write(memory, 0)) {
    std::cerr << "m100: " << printable(path_) << ": " << why_not_written(errno)
              << "; signatures of this flight could be played back to the next one\n";
  }
}

}  // namespace m100::companion
