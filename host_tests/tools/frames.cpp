// SPDX-License-Identifier: BSD-3-Clause
// m100-lab frames: bytes of the DJI link to JSON lines, and back.
#include <fstream>
#include <iostream>
#include <memory>
#include <optional>
#include <vector>

#include "host_tests/tools/frames/frame_text.h"
#include "host_tests/tools/frames/hex.h"
#include "host_tests/tools/frames/message_json.h"
#include "host_tests/tools/input_error.h"
#include "host_tests/tools/subcommands.h"
#include "protocol/aes256.h"
#include "protocol/frame_parser.h"

namespace m100::tools {
namespace {

struct Options {
  std::string file;  ///< empty or "-": standard input
  std::string key;
};

/// Standard input, or the file that is named.
class Input {
 public:
  explicit Input(const std::string& file) : name_(file.empty() || file == "-" ? "standard input" : file) {
    if (name_ == file) {
      file_.open(file, std::ios::binary);
      if (!file_) {
        throw InputError(file, 0, "", "cannot be read");
      }
      if (file_.peek() == std::ifstream::traits_type::eof() && file_.bad()) {
        throw InputError(file, 0, "", "is not a file that can be read");
      }
      file_.clear();
    }
  }
  std::istream& stream() { return file_.is_open() ? file_ : std::cin; }
  const std::string& name() const { return name_; }

 private:
  std::string name_;
  std::ifstream file_;
};

void print(const Json& line) { std::cout << line.dump(-1, ' ', true, Json::error_handler_t::replace) << '\n'; }

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

void decode(const Options& options) {
  std::optional<protocol::Aes256> cipher;
  if (!options.key.empty()) {
    cipher.emplace(parse_key(options.key, {"command line", 0}, "--key"));
  }
  Input input(options.file);
  protocol::FrameParser parser;
  CommandMemory memory;
  std::vector<char> chunk(65536);
  while (input.stream().read(chunk.data(), static_cast<std::streamsize>(chunk.size())), input.stream().gcount() > 0) {
    const auto count = static_cast<std::size_t>(input.stream().gcount());
    parser.consume(std::as_bytes(std::span(chunk).first(count)), [&](const protocol::FrameView& frame) {
      print(frame_line(frame, cipher ? &*cipher : nullptr, memory));
    });
  }
  print(statistics(parser));
}

void encode(const Options& options) {
  std::optional<protocol::CipherKey> key;
  if (!options.key.empty()) {
    key = parse_key(options.key, {"command line", 0}, "--key");
  }
  Input input(options.file);
  LineOrigin origin{input.name(), 0};
  for (std::string text; std::getline(input.stream(), text);) {
    ++origin.line;
    if (text.find_first_not_of(" \t\r") == std::string::npos) {
      continue;
    }
    const Json line = Json::parse(text, nullptr, false);
    if (!line.is_object()) {
      throw InputError(origin.file, origin.line, "", "is not a JSON object");
    }
    if (!line.contains("statistics")) {
      std::cout << to_hex(frame_from_line(line, origin, key)) << '\n';
    }
  }
}

}  // namespace

void add_frames(CLI::App& lab) {
  CLI::App* const frames = lab.add_subcommand("frames", "Bytes of the DJI link to JSON lines, and back");
  frames->require_subcommand(1);
  const auto options = std::make_shared<Options>();
  CLI::App* const decoder = frames->add_subcommand(
      "decode", "Raw bytes in, one JSON line per delivered frame out; the last line has the statistics");
  CLI::App* const encoder =
      frames->add_subcommand("encode", "JSON lines in, one frame in hexadecimal a line out; 'statistics' is skipped");
  for (CLI::App* const each : {decoder, encoder}) {
    each->add_option("file", options->file, "Input; standard input if left out");
    each->add_option("--key", options->key, "AES-256 key, 64 hexadecimal digits");
  }
  encoder->footer("A line may bring its own key_hex, and padding_hex (the filler of an encrypted frame).");
  decoder->callback([options] { decode(*options); });
  encoder->callback([options] { encode(*options); });
}

}  // namespace m100::tools
