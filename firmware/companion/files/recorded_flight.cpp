// SPDX-License-Identifier: BSD-3-Clause
#include "firmware/companion/files/recorded_flight.h"

#include <array>
#include <cstring>
#include <span>
#include <utility>

#include "firmware/companion/files/text/regular_file.h"

namespace m100::companion {
namespace {

constexpr std::size_t kHeaderBytes = 16;
constexpr std::array<char, 8> kMagic{0x55, 0x4C, 0x6F, 0x67, 0x01, 0x12, 0x35, 0x01};

class Reader {
 public:
  Reader(std::string path, std::string bytes) : path_(std::move(path)), bytes_(std::move(bytes)) {}

  RecordedFlight read() {
    if (bytes_.size() < kHeaderBytes || std::memcmp(bytes_.data(), kMagic.data(), kMagic.size()) != 0) {
      fail(0, "not a ULog file");
    }
    std::size_t at = kHeaderBytes;
    while (at + 3 <= bytes_.size()) {
      const std::size_t size = byte(at) + 256U * byte(at + 1);
      if (at + 3 + size > bytes_.size()) {
        break;  // truncated while it was written
      }
      message(bytes_[at + 2], at + 3, size);
      at += 3 + size;
    }
    if (!formats_seen_) {
      fail(at, "no tick record: not a log of this program, or of another version");
    }
    return std::move(flight_);
  }

 private:
  [[noreturn]] void fail(std::size_t at, const std::string& what) const {
    throw FlightLogError(path_ + ": byte " + std::to_string(at) + ": " + what);
  }
  std::size_t byte(std::size_t at) const { return static_cast<unsigned char>(bytes_[at]); }

  void message(char type, std::size_t at, std::size_t size) {
    const std::string_view body(bytes_.data() + at, size);
    if (type == 'F' && body.starts_with("tick:")) {
      if (body != log::kTickFormat) {
        fail(at, "tick record of another version");
      }
      formats_seen_ = true;
    } else if (type == 'F' && body.starts_with("link_bytes:") && body != log::kBytesFormat) {
      fail(at, "byte record of another version");
    } else if (type == 'I') {
      note(body, at);
    } else if (type == 'L') {
      flight_.flew_mission = flight_.flew_mission || body.ends_with("mission: active");
    } else if (type == 'D' && size >= 2) {
      data(byte(at) + 256U * byte(at + 1), body.substr(2), at);
    }
  }

  void note(std::string_view body, std::size_t at) {
    const std::size_t key_size = body.empty() ? 0 : static_cast<unsigned char>(body.front());
    if (1 + key_size > body.size()) {
      fail(at, "damaged note");
    }
    const std::string_view type_and_key = body.substr(1, key_size);
    const std::size_t space = type_and_key.find(' ');
    if (space != std::string_view::npos) {
      flight_.notes[std::string(type_and_key.substr(space + 1))] = std::string(body.substr(1 + key_size));
    }
  }

  static std::vector<std::byte>& stream_of(RecordedFlight::Tick& tick, log::Stream stream) {
    return stream == log::Stream::kAutopilotIn    ? tick.autopilot_in
           : stream == log::Stream::kAutopilotOut ? tick.autopilot_out
           : stream == log::Stream::kPoseOut      ? tick.pose_out
                                                  : tick.pose_in;
  }

  void data(std::size_t id, std::string_view body, std::size_t at) {
    if (flight_.notes.contains("m100_recording")) {
      throw FlightLogError(path_ +
                           ": is a recording of m100 record, which has no ticks: read it with m100-lab identify");
    }
    if (id == 0 && body.size() == sizeof(log::TickRecord)) {
      open_tick();
      std::memcpy(&flight_.ticks.back().record, body.data(), body.size());
      has_open_tick_ = false;
    } else if (id == 1 && body.size() == sizeof(log::BytesRecord)) {
      log::BytesRecord record;
      std::memcpy(&record, body.data(), body.size());
      if (record.count > record.bytes.size()) {
        fail(at, "byte record with an impossible length");
      }
      open_tick();
      const auto bytes = std::as_bytes(std::span(record.bytes).first(record.count));
      std::vector<std::byte>& stream = stream_of(flight_.ticks.back(), static_cast<log::Stream>(record.stream));
      stream.insert(stream.end(), bytes.begin(), bytes.end());
    } else if (id == 2 && body.size() == sizeof(log::ExcitationRecord)) {
      open_tick();
      std::memcpy(&flight_.ticks.back().excitation.emplace(), body.data(), body.size());
    } else if (id != 3 || body.size() != sizeof(log::VibrationRecord)) {  // a replay computes the vibration again
      fail(at, "data record of unknown size");
    }
  }

  /// Begins a tick, if none is open: the bytes of a tick come before its record.
  void open_tick() {
    if (!has_open_tick_) {
      flight_.ticks.emplace_back();
      has_open_tick_ = true;
    }
  }

  std::string path_;
  std::string bytes_;
  RecordedFlight flight_;
  bool formats_seen_ = false;
  bool has_open_tick_ = false;
};

}  // namespace

RecordedFlight read_flight(const std::string& path) {
  FileContent content = read_regular(path);
  if (!content.why_not.empty()) {
    throw FlightLogError(path + ": " + content.why_not);
  }
  return parse_flight_log(std::move(content.bytes), path);
}

RecordedFlight parse_flight_log(std::string bytes, const std::string& name) {
  RecordedFlight flight = Reader(name, std::move(bytes)).read();
  if (!flight.ticks.empty() && flight.ticks.back().record.timestamp == 0) {
    flight.ticks.pop_back();  // its record is missing
  }
  return flight;
}

}  // namespace m100::companion
