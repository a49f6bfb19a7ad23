// SPDX-License-Identifier: BSD-3-Clause
// m100-lab frames: converts bytes of the DJI link to JSON lines, and back.
#include <fcntl.h>
#include <unistd.h>
#include <array>
#include <cerrno>
#include <cstring>
#include <iostream>
#include <memory>
#include <optional>
#include <span>
#include <sstream>

#include "firmware/companion/command_line.h"
#include "firmware/companion/files/file_use.h"
#include "firmware/companion/files/text/key_file.h"
#include "hal/linux/descriptor.h"
#include "host_tests/lab/frames/frame_text.h"
#include "host_tests/lab/frames/hex.h"
#include "host_tests/lab/frames/message_json.h"
#include "host_tests/lab/input_error.h"
#include "host_tests/lab/json_file.h"
#include "host_tests/lab/subcommands.h"
#include "protocol/aes256.h"
#include "protocol/dji/frame_parser.h"

namespace m100::lab {
namespace {

struct FramesOptions {
  std::string file;  ///< empty or "-": standard input, which may be endless
  std::string key_file;

  void check_files() const {
    companion::FileUse().reads("file", file == "-" ? "" : file).reads("--key-file", key_file).check();
  }
};

/// Standard input, or the named file. Bytes are passed on as they arrive, so that a live port can be watched.
class Input {
 public:
  explicit Input(const std::string& file)
      : name_(file.empty() || file == "-" ? "standard input" : file),
        descriptor_(name_ == file ? ::open(file.c_str(), O_RDONLY | O_CLOEXEC) : ::dup(STDIN_FILENO)) {
    if (descriptor_.number < 0) {
      throw InputError(name_, 0, "", std::string("cannot be read: ") + std::strerror(errno));
    }
  }

  /// @returns the available bytes, at least one; empty at the end.
  std::span<const char> read() {
    ssize_t count = -1;
    do {
      count = ::read(descriptor_.number, space_.data(), space_.size());
    } while (count < 0 && errno == EINTR);
    if (count < 0) {
      throw InputError(name_, 0, "", std::string("cannot be read: ") + std::strerror(errno));
    }
    return std::span<const char>(space_).first(static_cast<std::size_t>(count));
  }

  const std::string& name() const { return name_; }

 private:
  std::string name_;
  hal::Descriptor descriptor_;
  std::array<char, 65536> space_{};
};

void print(const Json& line) { std::cout << line.dump(-1, true) << '\n'; }

Json statistics(const protocol::FrameParser& parser) {
  const protocol::ParserStats& stats = parser.stats();
  return {{"statistics",
           {{"frames", stats.frames},
            {"crc16_errors", stats.crc16_errors},
            {"crc32_errors", stats.crc32_errors},
            {"resyncs", stats.resyncs},
            {"bytes_dropped", stats.bytes_dropped + parser.pending_bytes()},
            {"reserved_errors", stats.reserved_errors},
            {"length_errors", stats.length_errors},
            {"padding_errors", stats.padding_errors},
            {"bytes", stats.bytes},
            {"bytes_unfinished", parser.pending_bytes()}}}};
}

void decode(const FramesOptions& options) {
  options.check_files();
  std::optional<protocol::Aes256> cipher;
  if (!options.key_file.empty()) {
    cipher.emplace(companion::read_key(options.key_file));
  }
  Input input(options.file);
  protocol::FrameParser parser;
  CommandMemory memory;
  for (auto chunk = input.read(); !chunk.empty(); chunk = input.read()) {
    parser.consume(std::as_bytes(chunk), [&](const protocol::FrameView& frame) {
      print(frame_line(frame, cipher ? &*cipher : nullptr, memory));
    });
    std::cout.flush();
  }
  print(statistics(parser));
}

void encode(const FramesOptions& options) {
  options.check_files();
  std::optional<protocol::CipherKey> key;
  if (!options.key_file.empty()) {
    key = companion::read_key(options.key_file);
  }
  Input input(options.file);
  std::string all;
  for (auto chunk = input.read(); !chunk.empty(); chunk = input.read()) {
    all.append(chunk.begin(), chunk.end());
  }
  std::istringstream lines(std::move(all));
  LineOrigin origin{input.name(), 0};
  for (std::string text; std::getline(lines, text);) {
    ++origin.line;
    if (text.find_first_not_of(" \t\r") == std::string::npos) {
      continue;
    }
    const Json line = Json::parse(text);
    if (!line.is_object()) {
      throw InputError(origin.file, origin.line, "", "is not a JSON object");
    }
    if (!line.contains("statistics")) {
      std::cout << to_hex(frame_from_line(line, origin, key)) << '\n';
    }
  }
}

}  // namespace

void add_frames(companion::CommandLine& lab) {
  const companion::Subcommand frames =
      lab.add_subcommand("frames", "Convert bytes of the DJI link to JSON lines, and back");
  frames.require_subcommand();
  const auto options = std::make_shared<FramesOptions>();
  const companion::Subcommand decoder = frames.add_subcommand(
      "decode", "Raw bytes in, one JSON line per delivered frame out; the last line has the statistics");
  const companion::Subcommand encoder =
      frames.add_subcommand("encode", "JSON lines in, one frame in hexadecimal a line out; 'statistics' is skipped");
  for (const companion::Subcommand& each : {decoder, encoder}) {
    each.add_option("file", options->file, "Input; standard input if left out");
    each.add_option("--key-file", options->key_file,
                    "file with the AES-256 key (64 hexadecimal digits, readable by its owner only)");
  }
  encoder.footer("A line may contain its own key_hex, and padding_hex (the filler of an encrypted frame).");
  decoder.callback([options] { decode(*options); });
  encoder.callback([options] { encode(*options); });
}

}  // namespace m100::lab
