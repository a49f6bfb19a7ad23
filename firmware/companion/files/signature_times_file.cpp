// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/files/signature_times_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <span>
#include <sstream>

#include "firmware/companion/files/text/printable.h"
#include "firmware/companion/files/text/text_file.h"
#include "firmware/companion/files/text/toml_text.h"
#include "firmware/companion/subcommands.h"

namespace m100::companion {
namespace {

constexpr const char* kFirstLine =
    "# Newest MAVLink signatures accepted with this key. Without this file, recorded frames would be accepted again.";

constexpr const char* kDamaged = "is not what m100 writes";

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

/// The text of an earlier version, "newest TIME" and lines of "stream SYSTEM COMPONENT LINK TIME", as TOML in the same
/// lines.
std::string toml_of(const std::string& text) {
  std::istringstream lines(text);
  std::string out, line;
  bool has_streams = false;
  while (std::getline(lines, line)) {
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word == "stream") {
      out += has_streams ? "[" : "streams = [[";
      has_streams = true;
      while (words >> word) {
        out += word + ",";
      }
      line = "],";
    }
    out += (word == "newest" ? word + " =" + line.substr(word.size()) : line) + "\n";
  }
  return out + (has_streams ? "]" : "");
}

/// A whole number from 0 to `max`.
std::uint64_t whole(const TomlNode& node, std::uint64_t max) {
  if (!node.is(TomlNode::Kind::kNumber) || !(node.number() >= 0.0 && node.number() <= static_cast<double>(max)) ||
      node.number() != std::floor(node.number())) {
    node.refuse(kDamaged);
  }
  return static_cast<std::uint64_t>(node.number());
}

mavlink::ReplayStream stream_of(const TomlNode& node) {
  if (!node.is_array() || node.entries().size() != 4) {
    node.refuse(kDamaged);
  }
  const auto byte = [&node](std::size_t k) { return static_cast<std::uint8_t>(whole(node.entries()[k], 255)); };
  return {.from = {byte(0), byte(1)}, .link = byte(2), .last = whole(node.entries()[3], mavlink::kSignatureTimeMask)};
}

mavlink::ReplayMemory memory_of(const TomlNode& root) {
  mavlink::ReplayMemory memory;
  if (root.get("newest") == nullptr) {
    root.refuse(kDamaged);
  }
  memory.newest = whole(*root.get("newest"), mavlink::kSignatureTimeMask);
  for (const TomlNode& node : root.entries()) {
    if (node.key() == "newest") {
      continue;
    }
    if (node.key() != "streams" || !node.is_array()) {
      node.refuse(kDamaged);
    }
    for (const TomlNode& stream : node.entries()) {
      if (memory.count == memory.streams.size()) {
        stream.refuse(kDamaged);
      }
      memory.streams[memory.count++] = stream_of(stream);
    }
  }
  return memory;
}

}  // namespace

mavlink::ReplayMemory parse_replay_memory(const std::string& text, const std::string& name) {
  try {
    return memory_of(parse_toml(text.find('=') == std::string::npos ? toml_of(text) : text, name));
  } catch (const FileError& wrong) {
    throw FileError(std::string(wrong.what()) +
                    "; make a new key, or remove the file if nobody recorded earlier flights");
  }
}

std::string text_of(const mavlink::ReplayMemory& memory, mavlink::SignatureTime ahead) {
  std::ostringstream text;
  text << kFirstLine << "\nnewest = " << memory.newest << "\nstreams = [  # system, component, link, time\n";
  for (const mavlink::ReplayStream& stream : std::span(memory.streams).first(memory.count)) {
    text << "  [" << unsigned{stream.from.system} << ", " << unsigned{stream.from.component} << ", "
         << unsigned{stream.link} << ", " << std::min(stream.last + ahead, mavlink::kSignatureTimeMask) << "],\n";
  }
  text << "]\n";
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
  writer_ = std::jthread([this](const std::stop_token& ends) {
    constexpr auto kLook = std::chrono::milliseconds(20);  // longest delay at the end of the program
    constexpr int kLooksPerWrite = 50;
    mavlink::ReplayMemory memory;
    bool has_news = false;
    for (int look = 0; !ends.stop_requested(); look = (look + 1) % kLooksPerWrite) {
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

void SignatureTimesFile::finish(const mavlink::ReplayMemory& memory) {
  writer_ = {};  // asked to end, and waited for
  if (!write(memory, 0)) {
    std::cerr << "m100: " << printable(path_) << ": " << why_not_written(errno)
              << "; signatures of this flight could be played back to the next one\n";
  }
}

}  // namespace m100::companion
