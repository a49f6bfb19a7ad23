// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <map>
#include <sstream>
#include <string_view>

#include "host_tests/tools/input_error.h"
#include "host_tests/tools/logs/raw_log.h"

// ULog, as PX4 documents it: 16 bytes of header, then messages of {uint16 size, uint8 type, payload}. Definitions 'F'
// name the fields of a format, subscriptions 'A' give a format a number, data 'D' carry that number and the bytes.

namespace m100::tools::logs {
namespace {

constexpr std::size_t kHeaderBytes = 16;
constexpr int kDeepestNesting = 8;

struct Field {
  std::string name;
  std::string type;  // a basic type
  std::size_t at;    // offset in the data, behind the message number
};

struct Topic {
  std::vector<Field> fields;
  std::size_t bytes = 0;
  std::vector<std::size_t> messages;  // offsets of their data in the file
};

template <typename T>
double read_as(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return static_cast<double>(value);
}

struct Basic {
  std::size_t bytes;
  double (*read)(const char*);
};

const std::map<std::string, Basic>& basic_types() {
  static const std::map<std::string, Basic> types{
      {"int8_t", {1, &read_as<std::int8_t>}},   {"uint8_t", {1, &read_as<std::uint8_t>}},
      {"bool", {1, &read_as<std::uint8_t>}},    {"char", {1, &read_as<std::uint8_t>}},
      {"int16_t", {2, &read_as<std::int16_t>}}, {"uint16_t", {2, &read_as<std::uint16_t>}},
      {"int32_t", {4, &read_as<std::int32_t>}}, {"uint32_t", {4, &read_as<std::uint32_t>}},
      {"int64_t", {8, &read_as<std::int64_t>}}, {"uint64_t", {8, &read_as<std::uint64_t>}},
      {"float", {4, &read_as<float>}},          {"double", {8, &read_as<double>}}};
  return types;
}

class ULog final : public RawLog {
 public:
  explicit ULog(const std::string& file) : RawLog(file) {
    std::ifstream in(file, std::ios::binary);
    std::stringstream buffer;
    buffer << in.rdbuf();
    bytes_ = buffer.str();
    if (bytes_.size() < kHeaderBytes) {
      throw InputError(file, 0, "", "is too short for a ULog header");
    }
    read_messages();
    if (topics_.empty()) {
      throw InputError(file, 0, "", "holds no topic");
    }
  }

  std::vector<std::string> names() const override {
    std::vector<std::string> all;
    for (const auto& [name, topic] : topics_) {
      for (const Field& field : topic.fields) {
        all.push_back(name + "." + field.name);
      }
    }
    return all;
  }

  RawColumn column(const std::string& name, const std::string& asked_by) const override {
    for (const auto& [topic_name, topic] : topics_) {
      if (name.rfind(topic_name + ".", 0) == 0) {
        for (const Field& field : topic.fields) {
          if (name.size() == topic_name.size() + 1 + field.name.size() && name.ends_with(field.name)) {
            return read(topic, field, name);
          }
        }
      }
    }
    throw InputError(file(), 0, name,
                     "no such column (wanted for " + asked_by + "); there are: " + nearest_names(names(), name));
  }

 private:
  [[noreturn]] void damaged(std::size_t at, const std::string& what) const {
    throw InputError(file(), 0, "byte " + std::to_string(at), what);
  }

  void read_messages() {
    for (std::size_t at = kHeaderBytes; at + 3 <= bytes_.size();) {
      const auto size = static_cast<std::size_t>(read_as<std::uint16_t>(bytes_.data() + at));
      const char type = bytes_[at + 2];
      const std::size_t begin = at + 3;
      if (begin + size > bytes_.size()) {
        return;  // a log cut by loss of power ends in half a message; what came before is good
      }
      take_message(type, begin, size);
      at = begin + size;
    }
  }

  void take_message(char type, std::size_t begin, std::size_t size) {
    const std::string_view payload(bytes_.data() + begin, size);
    if (type == 'F') {
      const std::size_t colon = payload.find(':');
      if (colon == std::string_view::npos) {
        damaged(begin, "a format without a name");
      }
      formats_[std::string(payload.substr(0, colon))] = std::string(payload.substr(colon + 1));
    } else if (type == 'A' && size > 3) {
      subscribe(payload, begin);
    } else if (type == 'D' && size >= 2) {
      const auto id = static_cast<int>(read_as<std::uint16_t>(payload.data()));
      const auto found = by_id_.find(id);
      if (found == by_id_.end() || size - 2 < found->second->bytes) {
        damaged(begin, "data of a topic that was not announced, or too short for it");
      }
      found->second->messages.push_back(begin + 2);
    }
  }

  void subscribe(std::string_view payload, std::size_t at) {
    const auto instance = static_cast<unsigned>(static_cast<unsigned char>(payload[0]));
    const auto id = static_cast<int>(read_as<std::uint16_t>(payload.data() + 1));
    const std::string name(payload.substr(3));
    Topic topic;
    expand(name, "", topic, at, 0);
    Topic& stored = topics_[instance == 0 ? name : name + "#" + std::to_string(instance)];
    if (stored.fields.empty()) {
      stored = topic;
    }
    by_id_[id] = &stored;
  }

  void expand(const std::string& format, const std::string& prefix, Topic& topic, std::size_t at, int depth) const {
    const auto found = formats_.find(format);
    if (found == formats_.end() || depth > kDeepestNesting) {
      damaged(at, "unknown format '" + format + "'");
    }
    std::stringstream fields(found->second);
    for (std::string one; std::getline(fields, one, ';');) {
      const std::size_t space = one.find(' ');
      if (space == std::string::npos) {
        damaged(at, "field '" + one + "' has no name");
      }
      add_field(one.substr(0, space), prefix + one.substr(space + 1), topic, at, depth);
    }
  }

  void add_field(std::string type, const std::string& name, Topic& topic, std::size_t at, int depth) const {
    std::size_t count = 1;
    const std::size_t open = type.find('[');
    const bool is_array = open != std::string::npos;
    if (is_array) {
      count = static_cast<std::size_t>(std::strtoul(type.c_str() + open + 1, nullptr, 10));
      type.resize(open);
    }
    const auto basic = basic_types().find(type);
    for (std::size_t i = 0; i < count; ++i) {
      const std::string full = is_array ? name + "[" + std::to_string(i) + "]" : name;
      if (basic == basic_types().end()) {
        expand(type, full + ".", topic, at, depth + 1);
        continue;
      }
      if (name.find("_padding") == std::string::npos) {
        topic.fields.push_back({full, type, topic.bytes});
      }
      topic.bytes += basic->second.bytes;
    }
  }

  RawColumn read(const Topic& topic, const Field& field, const std::string& name) const {
    const Basic basic = basic_types().at(field.type);
    const Field& clock = topic.fields.front();
    if (clock.name != "timestamp") {
      throw InputError(file(), 0, name, "the topic has no timestamp");
    }
    if (topic.messages.empty()) {
      throw InputError(file(), 0, name, "the topic has no messages");
    }
    RawColumn column;
    for (const std::size_t message : topic.messages) {
      const char* data = bytes_.data() + message;
      column.time_s.push_back(1e-6 * basic_types().at(clock.type).read(data + clock.at));
      const double value = basic.read(data + field.at);
      column.values.push_back(&field == &clock ? column.time_s.back() : value);
      if (!std::isfinite(value)) {
        throw InputError(file(), static_cast<long>(column.values.size()), name,
                         "message " + std::to_string(column.values.size()) + " is not a finite number");
      }
    }
    return column;
  }

  std::string bytes_;
  std::map<std::string, std::string> formats_;
  std::map<std::string, Topic> topics_;
  std::map<int, Topic*> by_id_;
};

}  // namespace

std::unique_ptr<RawLog> open_ulog(const std::string& file) { return std::make_unique<ULog>(file); }

}  // namespace m100::tools::logs
