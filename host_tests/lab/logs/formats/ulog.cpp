// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/logs/formats/ulog.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "host_tests/lab/input_error.h"
#include "host_tests/lab/logs/formats/read_number.h"
#include "host_tests/lab/logs/formats/ulog_format.h"
#include "host_tests/lab/whole_file.h"

// ULog, as PX4 documents it: 16 bytes of header, then messages of {uint16 size, uint8 type, payload}. Definitions 'F'
// name the fields of a format, subscriptions 'A' number its instances, data 'D' carry that number and the bytes. The
// flags 'B' may announce data that were appended later, after a message that a loss of power cut short. PX4 omits
// the padding at the end of a format, so a message may be shorter than its format says.

namespace m100::lab::logs {
namespace {

using namespace std::string_view_literals;

constexpr std::size_t kHeaderBytes = 16;
constexpr std::size_t kFlagBytes = 40;
constexpr auto kSync = "\x08\x00S\x2f\x73\x13\x20\x25\x0c\xbb\x12"sv;  // a complete message, to resynchronise
constexpr auto kKnownTypes = "BFIMPQADLCSOR"sv;
constexpr unsigned kAppended = 1;  // the only incompatible flag that is defined

struct Message {
  std::size_t at;    ///< of its data in the file, after the message's number
  std::size_t size;  ///< of its data
};

struct Topic {
  std::string format;
  std::vector<Message> messages;
};

class ULog final : public RawLog {
 public:
  explicit ULog(const std::string& file) : RawLog(file), bytes_(whole_file(file)) {
    if (bytes_.size() < kHeaderBytes) {
      throw InputError(file, 0, "", "is too short for a ULog header");
    }
    read_sections();
    if (topics_.empty()) {
      throw InputError(file, 0, "", "holds no topic");
    }
  }

  std::string format() const override { return "ULog"; }
  bool has_times_of_arrival() const override { return false; }

  std::vector<std::string> names() const override {
    std::vector<std::string> all;
    for (const auto& [key, topic] : topics_) {
      if (!topic.messages.empty() && all.size() < kMaxNames) {
        formats_.list(topic.format, name_of(key) + ".", kMaxNames, all);
      }
    }
    return all;
  }

  RawColumn column(const std::string& name, const std::string& map_key) const override {
    const std::size_t dot = std::min(name.find('.'), name.size() - (name.empty() ? 0 : 1));
    const auto topic = topics_.find(key_of(name.substr(0, dot)));
    if (topic == topics_.end()) {
      no_such_column(name, map_key);
    }
    const std::string_view path = std::string_view(name).substr(dot + 1);
    const auto found = formats_.find(topic->second.format, path);
    if (!found) {
      no_such_column(name, map_key);
    }
    if (topic->second.messages.empty()) {
      throw InputError(file(), 0, name, "the topic has no messages");
    }
    RawColumn column{.values = {}, .time_s = times(topic->second), .sequence = {}};
    if (column.time_s.empty()) {
      throw InputError(file(), 0, name, "the topic has no timestamp");
    }
    column.values = path == "timestamp" ? column.time_s : values(topic->second, *found);
    require_mostly_sound(column.values, name);
    return column;
  }

  std::vector<TopicSummary> topics() const override {
    std::vector<TopicSummary> all;
    std::size_t room = kMaxNames;
    for (const auto& [key, topic] : topics_) {
      all.push_back(summary_of(name_of(key), topic.format, times(topic), formats_.fields(topic.format, room)));
      room -= all.back().fields.size();
      all.back().messages = topic.messages.size();
    }
    return all;
  }

  std::vector<std::string> notes() const override {
    std::vector<std::string> out;
    if (lost_bytes_ > 0) {
      out.push_back(std::to_string(lost_bytes_) + " bytes of the file are damaged and were skipped");
    }
    if (foreign_ > 0) {
      out.push_back(std::to_string(foreign_) + " messages of topics that were never announced were left out");
    }
    if (dropouts_ > 0) {
      out.push_back("the logger itself reports " + std::to_string(dropouts_) + " dropouts, " +
                    std::to_string(dropout_ms_) + " ms in all");
    }
    return out;
  }

 private:
  using Key = std::pair<std::string, unsigned>;  // name and instance

  static std::string name_of(const Key& key) {
    return key.first + (key.second == 0 ? "" : ":" + std::to_string(key.second));
  }

  /// The key of "topic" or "topic:1", or of "topic#1", which earlier versions of this program wrote.
  static Key key_of(const std::string& text) {
    const std::size_t mark = text.find_first_of(":#");
    unsigned instance = 0;
    for (std::size_t i = mark; i != std::string::npos && ++i < text.size();) {
      const bool digit = text[i] >= '0' && text[i] <= '9';
      instance = digit && instance < 1000 ? 10 * instance + static_cast<unsigned>(text[i] - '0') : 1000;
    }
    return {text.substr(0, mark), instance};
  }

  std::vector<double> values(const Topic& topic, const UlogNumber& field) const {
    std::vector<double> out;
    out.reserve(topic.messages.size());
    for (const Message& message : topic.messages) {
      out.push_back(field.at + field.bytes <= message.size ? field.read(bytes_.data() + message.at + field.at)
                                                           : std::numeric_limits<double>::quiet_NaN());
    }
    return out;
  }

  /// The times of a topic in seconds; empty: the topic has no clock.
  std::vector<double> times(const Topic& topic) const {
    const auto clock = formats_.find(topic.format, "timestamp");
    std::vector<double> out = clock ? values(topic, *clock) : std::vector<double>{};
    for (double& t : out) {
      t *= 1e-6;
    }
    return out;
  }

  /// The offsets at which the file's first data and its appended data begin, according to its flags.
  std::vector<std::size_t> section_begins() const {
    std::vector<std::size_t> begins{kHeaderBytes};
    const char* const first = bytes_.data() + kHeaderBytes;
    if (bytes_.size() < kHeaderBytes + 3 + kFlagBytes || first[2] != 'B' ||
        read_number<std::uint16_t>(first) < kFlagBytes) {
      return begins;
    }
    const char* const flags = first + 3;
    for (std::size_t i = 8; i < 16; ++i) {
      const auto unknown = static_cast<unsigned>(static_cast<unsigned char>(flags[i])) & ~(i == 8 ? kAppended : 0U);
      if (unknown != 0) {
        throw InputError(file(), 0, "", "uses unknown features of ULog (incompatible flags)");
      }
    }
    for (std::size_t i = 16; (static_cast<unsigned char>(flags[8]) & kAppended) != 0 && i < kFlagBytes; i += 8) {
      const auto offset = read_number<std::uint64_t>(flags + i);
      if (offset > begins.back() && offset < bytes_.size()) {
        begins.push_back(static_cast<std::size_t>(offset));
      }
    }
    return begins;
  }

  /// Reads each section of the file, from its begin to the begin of the next one or to the end of the file.
  void read_sections() {
    const std::vector<std::size_t> begins = section_begins();
    for (std::size_t i = 0; i < begins.size(); ++i) {
      read_messages(begins[i], i + 1 < begins.size() ? begins[i + 1] : bytes_.size());
    }
  }

  void read_messages(std::size_t at, std::size_t end) {
    while (at + 3 <= end) {
      const auto size = static_cast<std::size_t>(read_number<std::uint16_t>(bytes_.data() + at));
      const char type = bytes_[at + 2];
      const std::size_t begin = at + 3;
      if (kKnownTypes.find(type) == std::string_view::npos || begin + size > end) {
        // Damage, or an incomplete last message: the data before it and after the next sync mark are good.
        const std::size_t mark = std::string_view(bytes_).substr(0, end).find(kSync, at);
        lost_bytes_ += std::min(mark, end) - at;
        at = std::min(mark, end);
        continue;
      }
      take_message(type, begin, size);
      at = begin + size;
    }
  }

  void take_message(char type, std::size_t begin, std::size_t size) {
    const std::string_view payload = std::string_view(bytes_).substr(begin, size);
    if (type == 'F') {
      lost_bytes_ += formats_.define(payload) ? 0 : size;
    } else if (type == 'A' && size > 3) {
      const auto instance = static_cast<unsigned>(static_cast<unsigned char>(payload[0]));
      const std::string name(payload.substr(3));
      Topic& topic = topics_[{name, instance}];
      topic.format = name;
      by_id_[read_number<std::uint16_t>(payload.data() + 1)] = &topic;
    } else if (type == 'D' && size >= 2) {
      const auto found = by_id_.find(read_number<std::uint16_t>(payload.data()));
      if (found == by_id_.end()) {
        ++foreign_;
      } else {
        found->second->messages.push_back({begin + 2, size - 2});
      }
    } else if (type == 'O' && size >= 2) {
      ++dropouts_;
      dropout_ms_ += read_number<std::uint16_t>(payload.data());
    }
  }

  std::string bytes_;
  mutable UlogFormats formats_;  // parsed when first used
  std::map<Key, Topic> topics_;
  std::unordered_map<std::uint16_t, Topic*> by_id_;
  std::size_t lost_bytes_ = 0, foreign_ = 0, dropouts_ = 0, dropout_ms_ = 0;
};

}  // namespace

std::unique_ptr<RawLog> open_ulog(const std::string& file) { return std::make_unique<ULog>(file); }

}  // namespace m100::lab::logs
