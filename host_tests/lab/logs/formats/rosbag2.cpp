// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/logs/formats/rosbag2.h"

#include <sqlite3.h>

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>

#include "host_tests/lab/input_error.h"
#include "host_tests/lab/logs/formats/ros_types.h"

// ROS 2 bag with sqlite3 storage: tables topics(id, name, type, serialization_format, ...), messages(topic_id,
// timestamp in ns, data in CDR) and, in newer bags, message_definitions. The file is treated as data: its views,
// triggers and functions are not run.

namespace m100::lab::logs {
namespace {

constexpr int kStepsAtATime = 1000;

struct CloseBase {
  void operator()(sqlite3* base) const { sqlite3_close(base); }
};
struct FinishStatement {
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
using Statement = std::unique_ptr<sqlite3_stmt, FinishStatement>;

/// A path as a URI, with its special characters escaped.
std::string address_of(const std::string& file) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string out = "file:";
  for (const char c : file) {
    if (c == '?' || c == '#' || c == '%') {
      const auto byte = static_cast<unsigned char>(c);
      out += '%';
      out += kDigits[byte >> 4U];
      out += kDigits[byte & 15U];
    } else {
      out += c;
    }
  }
  return out + "?mode=ro&immutable=1";
}

std::string text(sqlite3_stmt* statement, int column) {
  const unsigned char* const bytes = sqlite3_column_text(statement, column);
  return bytes == nullptr ? std::string()
                          : std::string(reinterpret_cast<const char*>(bytes),
                                        static_cast<std::size_t>(sqlite3_column_bytes(statement, column)));
}

class Bag2 final : public RosLog {
 public:
  explicit Bag2(const std::string& file) : RosLog(file) {
    const std::uintmax_t size = std::filesystem::file_size(file);
    steps_left_ = 10'000 + static_cast<std::int64_t>(size / 10);  // thousands of steps: far more than reading needs
    bytes_left_ = static_cast<std::size_t>(size);
    sqlite3* opened = nullptr;
    const int answer =
        sqlite3_open_v2(address_of(file).c_str(), &opened, SQLITE_OPEN_READONLY | SQLITE_OPEN_URI, nullptr);
    base_.reset(opened);
    check(answer);
    sqlite3_db_config(opened, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
    sqlite3_db_config(opened, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
    sqlite3_progress_handler(
        opened, kStepsAtATime, [](void* bag) { return --static_cast<Bag2*>(bag)->steps_left_ < 0 ? 1 : 0; }, this);
    require_tables();
    read_topics(read_definitions());
    read_messages();
    start();
  }

  std::string format() const override { return "ROS 2 bag"; }

 private:
  void check(int answer) const {
    if (answer != SQLITE_OK && answer != SQLITE_ROW && answer != SQLITE_DONE) {
      throw InputError(file(), 0, "",
                       std::string("is not a readable sqlite3 file: ") +
                           (base_ == nullptr ? sqlite3_errstr(answer) : sqlite3_errmsg(base_.get())));
    }
  }

  Statement prepare(const char* question) const {
    sqlite3_stmt* statement = nullptr;
    check(sqlite3_prepare_v2(base_.get(), question, -1, &statement, nullptr));
    return Statement(statement);
  }

  bool step(const Statement& statement) const {
    const int answer = sqlite3_step(statement.get());
    check(answer);
    return answer == SQLITE_ROW;
  }

  /// Checks that these are tables: a view instead could be a query that never ends.
  void require_tables() const {
    const Statement found = prepare(
        "SELECT count(*) FROM sqlite_master WHERE type = 'table' AND name IN ('topics', 'messages') "
        "AND sql NOT LIKE 'CREATE VIRTUAL%'");
    if (!step(found) || sqlite3_column_int(found.get(), 0) != 2) {
      throw InputError(file(), 0, "",
                       "is an sqlite3 file, but not a ROS 2 bag: it lacks the tables topics and messages");
    }
  }

  /// The definitions of the message types that the bag contains, by type.
  std::map<std::string, std::string> read_definitions() const {
    std::map<std::string, std::string> out;
    const Statement there = prepare(
        "SELECT count(*) FROM sqlite_master WHERE type = 'table' AND name = 'message_definitions' "
        "AND sql NOT LIKE 'CREATE VIRTUAL%' AND sql LIKE '%encoded_message_definition%'");
    if (!step(there) || sqlite3_column_int(there.get(), 0) != 1) {
      return out;
    }
    const Statement rows = prepare("SELECT topic_type, encoding, encoded_message_definition FROM message_definitions");
    while (step(rows)) {
      if (text(rows.get(), 1) == "ros2msg") {
        out[text(rows.get(), 0)] = text(rows.get(), 2);
      }
    }
    return out;
  }

  void read_topics(const std::map<std::string, std::string>& definitions) {
    const Statement rows = prepare("SELECT id, name, type, serialization_format FROM topics");
    while (step(rows)) {
      const std::string name = text(rows.get(), 1);
      RosTopic& topic = topics_[name];
      topic.type_name = text(rows.get(), 2);
      by_id_[sqlite3_column_int64(rows.get(), 0)] = &topic;
      const auto own = definitions.find(topic.type_name);
      const char* const known = RosType::known_definition(topic.type_name);
      if (text(rows.get(), 3) != "cdr") {
        topic.unknown = "is not encoded as CDR";
      } else if (own != definitions.end()) {
        topic.type = RosType(topic.type_name, own->second, RosWire::kCdr);
      } else if (known != nullptr) {
        topic.type = RosType(topic.type_name, known, RosWire::kCdr);
      } else {
        topic.unknown = "is unknown, and the bag does not define it";
      }
    }
  }

  void read_messages() {
    const Statement rows = prepare("SELECT topic_id, timestamp, data FROM messages ORDER BY timestamp");
    std::size_t foreign = 0;
    while (step(rows)) {
      const auto topic = by_id_.find(sqlite3_column_int64(rows.get(), 0));
      const void* const data = sqlite3_column_blob(rows.get(), 2);
      const auto size = static_cast<std::size_t>(sqlite3_column_bytes(rows.get(), 2));
      if (topic == by_id_.end()) {
        ++foreign;
        continue;
      }
      if (size > bytes_left_) {
        throw InputError(file(), 0, "", "claims more data than a file of this size can hold");
      }
      bytes_left_ -= size;
      bytes_.push_back(std::make_unique<std::string>(static_cast<const char*>(data), data == nullptr ? 0 : size));
      topic->second->messages.emplace_back(*bytes_.back(),
                                           1e-9 * static_cast<double>(sqlite3_column_int64(rows.get(), 1)));
    }
    if (foreign > 0) {
      notes_.push_back(std::to_string(foreign) + " messages of topics that were never announced were left out");
    }
  }

  std::unique_ptr<sqlite3, CloseBase> base_;
  std::map<std::int64_t, RosTopic*> by_id_;
  std::vector<std::unique_ptr<std::string>> bytes_;  // the memory of the messages' views
  std::int64_t steps_left_ = 0;
  std::size_t bytes_left_ = 0;
};

}  // namespace

std::unique_ptr<RawLog> open_rosbag2(const std::string& file) { return std::make_unique<Bag2>(file); }

}  // namespace m100::lab::logs
