// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/logs/formats/rosbag.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <string_view>

#ifdef M100_BZIP2
#include <bzlib.h>
#endif

#include "host_tests/lab/input_error.h"
#include "host_tests/lab/logs/formats/read_number.h"
#include "host_tests/lab/logs/formats/ros_types.h"
#include "host_tests/lab/whole_file.h"

// ROS 1 bag, format 2.0: records of {uint32 length, header, uint32 length, data}; a header is fields of {uint32 length,
// name=value}. Connections (op 7) contain the definition of their message, so that the reader needs to know no message;
// messages (op 2) lie in chunks (op 5). Indices (op 4, 6) are not needed.

namespace m100::lab::logs {
namespace {

constexpr std::string_view kMagic = "#ROSBAG V2.0\n";
constexpr std::size_t kExpansion = 100;  // of bz2: telemetry shrinks to a fifth, noise not at all
constexpr std::size_t kSmall = std::size_t{64} << 20U;

double stamp(const char* bytes) {
  return read_number<std::uint32_t>(bytes) + 1e-9 * read_number<std::uint32_t>(bytes + 4);
}

class Bag final : public RosLog {
 public:
  explicit Bag(const std::string& file) : RosLog(file) {
    buffers_.push_back(std::make_unique<std::string>(whole_file(file)));
    bytes_left_ = kSmall + kExpansion * buffers_.front()->size();
    const std::string_view bytes(*buffers_.front());
    records(bytes.substr(std::min(bytes.size(), kMagic.size())), true);
    start();
  }

  std::string format() const override { return "ROS 1 bag"; }

 private:
  [[noreturn]] void fail(const std::string& what) const { throw InputError(file(), 0, "", what); }

  std::string_view cut(std::string_view& bytes) const {
    if (bytes.size() < 4) {
      fail("ends in the middle of a record");
    }
    const auto length = static_cast<std::size_t>(read_number<std::uint32_t>(bytes.data()));
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
      const std::string_view from = bytes;
      if (!whole_record(from)) {
        if (topics_.empty()) {
          fail("ends in the middle of a record");
        }
        notes_.emplace_back("the bag ends in the middle of a record: it was not closed");
        return;
      }
      const auto header = fields(cut(bytes));
      const std::string_view data = cut(bytes);
      const char op = need(header, "op", 1)[0];
      if (op == 5 && chunks_allowed) {
        chunk(header, data);
      } else if (op == 7) {
        connection(header, data);
      } else if (op == 2) {
        const auto number_of = connections_.find(read_number<std::uint32_t>(need(header, "conn", 4).data()));
        if (number_of == connections_.end()) {
          fail("has a message of an unknown connection");
        }
        topics_[number_of->second].messages.emplace_back(data, stamp(need(header, "time", 8).data()));
      }
    }
  }

  /// Whether header and data both lie inside the bytes.
  static bool whole_record(std::string_view bytes) {
    for (int part = 0; part < 2; ++part) {
      if (bytes.size() < 4 || bytes.size() - 4 < read_number<std::uint32_t>(bytes.data())) {
        return false;
      }
      bytes.remove_prefix(4 + static_cast<std::size_t>(read_number<std::uint32_t>(bytes.data())));
    }
    return true;
  }

  void chunk(const std::map<std::string, std::string_view>& header, std::string_view data) {
    const std::string how(need(header, "compression", 0));
    if (how == "none") {
      records(data, false);
      return;
    }
#ifdef M100_BZIP2
    if (how == "bz2") {
      const auto size = static_cast<std::size_t>(read_number<std::uint32_t>(need(header, "size", 4).data()));
      if (size > bytes_left_) {
        fail("claims more data than a file of this size can hold");
      }
      bytes_left_ -= size;
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
    fail("is compressed with " + how + ", which is not supported: decompress it with rosbag decompress");
  }

  void connection(const std::map<std::string, std::string_view>& header, std::string_view data) {
    const auto inner = fields(data);
    const std::string name(need(header, "topic", 1));
    connections_[read_number<std::uint32_t>(need(header, "conn", 4).data())] = name;
    const std::string type(need(inner, "type", 1));
    const std::string text(need(inner, "message_definition", 0));
    RosTopic& topic = topics_[name];
    if (topic.type_name.empty()) {  // each publisher announces the topic again
      topic.type_name = type;
      topic.type = RosType(type, text, RosWire::kPacked);
    }
  }

  std::vector<std::unique_ptr<std::string>> buffers_;  // the memory of the messages' views
  std::map<std::uint32_t, std::string> connections_;
  std::size_t bytes_left_ = 0;  ///< bytes that chunks may still unpack to
};

}  // namespace

std::unique_ptr<RawLog> open_rosbag(const std::string& file) { return std::make_unique<Bag>(file); }

}  // namespace m100::lab::logs
