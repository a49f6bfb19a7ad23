// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <sstream>
#include <string_view>

#ifdef M100_BZIP2
#include <bzlib.h>
#endif

#include "host_tests/tools/input_error.h"
#include "host_tests/tools/logs/raw_log.h"

// ROS 1 bag, format 2.0: records of {uint32 length, header, uint32 length, data}; a header is fields of {uint32 length,
// name=value}. Connections (op 7) carry the text that defines their message, so that no message has to be known here;
// messages (op 2) lie in chunks (op 5). Indices (op 4, 6) are not needed.

namespace m100::tools::logs {
namespace {

constexpr std::string_view kMagic = "#ROSBAG V2.0\n";
constexpr int kDeepestNesting = 8;
constexpr std::size_t kLongestArray = 64;          // longer ones (images, scans) are stepped over
constexpr std::size_t kLargestChunk = 1UL << 30U;  // bytes, decompressed

struct Field {
  std::string type, name;
  bool array = false;
  std::size_t fixed = 0;  // elements of an array of fixed size; 0: the message says
};
using Types = std::map<std::string, std::vector<Field>>;

template <typename T>
double number(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return static_cast<double>(value);
}

double stamp(const char* bytes) { return number<std::uint32_t>(bytes) + 1e-9 * number<std::uint32_t>(bytes + 4); }

struct Basic {
  std::size_t bytes;
  double (*read)(const char*);
};

const Basic* basic(const std::string& type) {
  static const std::map<std::string, Basic> types{{"bool", {1, &number<std::uint8_t>}},
                                                  {"byte", {1, &number<std::int8_t>}},
                                                  {"char", {1, &number<std::uint8_t>}},
                                                  {"int8", {1, &number<std::int8_t>}},
                                                  {"uint8", {1, &number<std::uint8_t>}},
                                                  {"int16", {2, &number<std::int16_t>}},
                                                  {"uint16", {2, &number<std::uint16_t>}},
                                                  {"int32", {4, &number<std::int32_t>}},
                                                  {"uint32", {4, &number<std::uint32_t>}},
                                                  {"int64", {8, &number<std::int64_t>}},
                                                  {"uint64", {8, &number<std::uint64_t>}},
                                                  {"float32", {4, &number<float>}},
                                                  {"float64", {8, &number<double>}},
                                                  {"time", {8, &stamp}},
                                                  {"duration", {8, &stamp}}};
  const auto found = types.find(type);
  return found == types.end() ? nullptr : &found->second;
}

Field field_of(const std::string& type, const std::string& name) {
  Field out{type, name, false, 0};
  if (const std::size_t bracket = type.find('['); bracket != std::string::npos) {
    out.array = true;
    out.type = type.substr(0, bracket);
    out.fixed = static_cast<std::size_t>(std::atoi(type.c_str() + bracket + 1));
  }
  return out;
}

/// The definition of a message and of those it contains, as the connection carries them.
Types parse_definition(const std::string& own, const std::string& text) {
  Types types;
  std::string present = own;
  types[present];
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    line = line.substr(0, line.find('#'));
    std::istringstream words(line);
    std::string type, name;
    words >> type >> name;
    if (type == "MSG:") {
      present = name;
      types[present];
    } else if (!name.empty() && line.find('=') == std::string::npos && type.rfind("==", 0) != 0) {
      types[present].push_back(field_of(type, name));
    }
  }
  return types;
}

const std::vector<Field>* definition(const Types& types, const std::string& name) {
  const auto exact = types.find(name);
  if (exact != types.end()) {
    return &exact->second;
  }
  for (const auto& [full, fields] : types) {
    if (full.size() > name.size() && full.ends_with("/" + name)) {
      return &fields;
    }
  }
  return nullptr;
}

struct Topic {
  std::string type;
  Types types;
  std::vector<std::pair<std::string_view, double>> messages;  // bytes, time of reception
  // Filled by the first question:
  std::vector<std::string> names;
  std::vector<std::vector<double>> columns;
  std::vector<double> time_s;
};

class Bag final : public RawLog {
 public:
  explicit Bag(const std::string& file) : RawLog(file) {
    std::ifstream in(file, std::ios::binary);
    std::ostringstream all;
    all << in.rdbuf();
    buffers_.push_back(std::make_unique<std::string>(all.str()));
    const std::string_view bytes(*buffers_.front());
    records(bytes.substr(std::min(bytes.size(), kMagic.size())), true);
    double first = std::numeric_limits<double>::infinity();
    for (const auto& [name, topic] : topics_) {
      for (const auto& message : topic.messages) {
        first = std::min(first, message.second);
      }
    }
    start_s_ = first;
    if (!std::isfinite(first)) {
      fail("holds no message");
    }
  }

  RawColumn column(const std::string& name, const std::string& asked_by) const override {
    const std::size_t dot = name.find('.');
    const auto topic = topics_.find(name.substr(0, dot));
    if (topic == topics_.end() || dot == std::string::npos) {
      throw InputError(file(), 0, name, "no such topic (key " + asked_by + "); near: " + nearest_names(names(), name));
    }
    decode(topic->first, topic->second);
    const std::string field = name.substr(dot + 1);
    RawColumn out;
    out.time_s = topic->second.time_s;
    if (field == "time") {
      out.values = out.time_s;
      return out;
    }
    for (std::size_t k = 0; k < topic->second.names.size(); ++k) {
      if (topic->second.names[k] == field) {
        out.values = topic->second.columns[k];
        for (std::size_t i = 0; i < out.values.size(); ++i) {
          if (!std::isfinite(out.values[i])) {
            throw InputError(file(), line_of(i), name, "message is not a finite number");
          }
        }
        return out;
      }
    }
    throw InputError(file(), 0, name, "no such field (key " + asked_by + "); near: " + nearest_names(names(), name));
  }

  std::vector<std::string> names() const override {
    std::vector<std::string> out;
    for (const auto& [name, topic] : topics_) {
      decode(name, topic);
      out.push_back(name + ".time");
      for (const std::string& field : topic.names) {
        out.push_back(name + "." + field);
      }
    }
    return out;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { throw InputError(file(), 0, "rosbag", what); }

  std::string_view cut(std::string_view& bytes) const {
    if (bytes.size() < 4) {
      fail("ends in the middle of a record");
    }
    const auto length = static_cast<std::size_t>(number<std::uint32_t>(bytes.data()));
    if (bytes.size() - 4 < length) {
      fail("ends in the middle of a record");
    }
    const std::string_view out = bytes.substr(4, length);
    bytes.remove_prefix(4 + length);
    return out;
  }

  std::map<std::string, std::string_view> fields(std::string_view header) const {
    std::map<std::string, std::string_view> out;
    while (!header.empty()) {
      const std::string_view one = cut(header);
      const std::size_t equals = one.find('=');
      if (equals == std::string_view::npos) {
        fail("has a field without a value");
      }
      out[std::string(one.substr(0, equals))] = one.substr(equals + 1);
    }
    return out;
  }

  std::string_view need(const std::map<std::string, std::string_view>& header, const char* key,
                        std::size_t bytes) const {
    const auto found = header.find(key);
    if (found == header.end() || found->second.size() < bytes) {
      fail(std::string("has a record without ") + key);
    }
    return found->second;
  }

  void records(std::string_view bytes, bool chunks_allowed) {
    while (!bytes.empty()) {
      const auto header = fields(cut(bytes));
      const std::string_view data = cut(bytes);
      const char op = need(header, "op", 1)[0];
      if (op == 5 && chunks_allowed) {
        chunk(header, data);
      } else if (op == 7) {
        connection(header, data);
      } else if (op == 2) {
        const auto number_of =
            connections_.find(static_cast<std::uint32_t>(number<std::uint32_t>(need(header, "conn", 4).data())));
        if (number_of == connections_.end()) {
          fail("has a message of an unknown connection");
        }
        topics_[number_of->second].messages.emplace_back(data, stamp(need(header, "time", 8).data()));
      }
    }
  }

  void chunk(const std::map<std::string, std::string_view>& header, std::string_view data) {
    const std::string how(need(header, "compression", 0));
    if (how == "none") {
      records(data, false);
      return;
    }
#ifdef M100_BZIP2
    if (how == "bz2") {
      const auto size = static_cast<std::size_t>(number<std::uint32_t>(need(header, "size", 4).data()));
      if (size > kLargestChunk) {
        fail("has a chunk of more than 1 GB");
      }
      buffers_.push_back(std::make_unique<std::string>(size, '\0'));
      auto length = static_cast<unsigned>(size);
      std::string source(data);
      if (BZ2_bzBuffToBuffDecompress(buffers_.back()->data(), &length, source.data(),
                                     static_cast<unsigned>(source.size()), 0, 0) != BZ_OK ||
          length != size) {
        fail("has a damaged bz2 chunk");
      }
      records(*buffers_.back(), false);
      return;
    }
#endif
    fail("is compressed with " + how + ", which is not read: rosbag decompress makes it readable");
  }

  void connection(const std::map<std::string, std::string_view>& header, std::string_view data) {
    const auto inner = fields(data);
    const std::string name(need(header, "topic", 1));
    connections_[static_cast<std::uint32_t>(number<std::uint32_t>(need(header, "conn", 4).data()))] = name;
    Topic& topic = topics_[name];
    topic.type = std::string(need(inner, "type", 1));
    topic.types = parse_definition(topic.type, std::string(need(inner, "message_definition", 0)));
  }

  using Visit = std::function<void(const std::string& path, double value)>;

  void walk(const Types& types, const std::string& type, const std::string& path, std::string_view& bytes, int depth,
            bool show, const Visit& visit) const {
    const auto take = [&](std::size_t count) {
      if (bytes.size() < count) {
        fail("has a message that is shorter than its definition");
      }
      const char* const at = bytes.data();
      bytes.remove_prefix(count);
      return at;
    };
    if (const Basic* plain = basic(type)) {
      const double value = plain->read(take(plain->bytes));
      if (show) {
        visit(path, value);
      }
      return;
    }
    if (type == "string") {
      take(static_cast<std::size_t>(number<std::uint32_t>(take(4))));
      return;
    }
    const std::vector<Field>* const own = definition(types, type);
    if (own == nullptr || depth > kDeepestNesting) {
      fail("uses the type " + type + " without defining it");
    }
    for (const Field& field : *own) {
      const std::string below = path.empty() ? field.name : path + "." + field.name;
      if (!field.array) {
        walk(types, field.type, below, bytes, depth + 1, show, visit);
        continue;
      }
      const std::size_t count =
          field.fixed > 0 ? field.fixed : static_cast<std::size_t>(number<std::uint32_t>(take(4)));
      const Basic* const plain = basic(field.type);
      if (plain != nullptr && count > kLongestArray) {
        if (count > bytes.size()) {
          fail("has a message that is shorter than its definition");
        }
        take(count * plain->bytes);
        continue;
      }
      for (std::size_t k = 0; k < count; ++k) {
        walk(types, field.type, below + "[" + std::to_string(k) + "]", bytes, depth + 1, show && k < kLongestArray,
             visit);
      }
    }
  }

  /// All numbers of all messages of a topic, once. A message whose arrays have another length than the first one's is
  /// an error: its numbers would slip into other columns.
  void decode(const std::string& name, const Topic& constant) const {
    Topic& topic = topics_.at(name);
    if (!constant.time_s.empty() || constant.messages.empty()) {
      return;
    }
    int stamp_s = -1;
    for (const auto& [bytes, received_s] : topic.messages) {
      std::string_view rest = bytes;
      std::size_t k = 0;
      const bool first = topic.time_s.empty();
      walk(topic.types, topic.type, "", rest, 0, true, [&](const std::string& path, double value) {
        if (first) {
          stamp_s = path == "header.stamp" ? static_cast<int>(k) : stamp_s;
          topic.names.push_back(path);
          topic.columns.emplace_back();
        }
        if (k < topic.columns.size()) {
          topic.columns[k].push_back(value);
        }
        ++k;
      });
      if (k != topic.columns.size()) {
        fail("topic " + name + " has arrays that change their length");
      }
      const double stamped = stamp_s >= 0 ? topic.columns[static_cast<std::size_t>(stamp_s)].back() : 0.0;
      topic.time_s.push_back((stamped > 0.0 ? stamped : received_s) - start_s_);
    }
  }

  std::vector<std::unique_ptr<std::string>> buffers_;  // what the messages' views look at
  std::map<std::uint32_t, std::string> connections_;
  mutable std::map<std::string, Topic> topics_;
  double start_s_ = 0.0;
};

}  // namespace

std::unique_ptr<RawLog> open_rosbag(const std::string& file) { return std::make_unique<Bag>(file); }

}  // namespace m100::tools::logs
