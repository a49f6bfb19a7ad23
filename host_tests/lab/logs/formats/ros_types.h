// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host_tests/lab/logs/raw_log.h"

namespace m100::lab::logs {

/// The byte layout of a message.
enum class RosWire {
  kPacked,  ///< ROS 1: little endian, no padding, strings with their length
  kCdr      ///< ROS 2: a header of four bytes, primitives aligned to their size, strings with their NUL
};

/// The definition of a message type and of its inner types, from the text in the bag or, for ROS 2 bags without one,
/// from a few built-in types: Imu, PoseStamped, PoseWithCovarianceStamped, Odometry, QuaternionStamped,
/// TransformStamped, TwistStamped, Vector3Stamped, Joy.
class RosType {
 public:
  RosType() = default;
  /// @param own name of the outer type. @param text its definition as in ROS 1 or ROS 2.
  RosType(const std::string& own, const std::string& text, RosWire wire);
  /// The definition of a built-in type; nullptr: there is none.
  static const char* known_definition(const std::string& type);

  using Visit = std::function<void(const std::string& path, double value)>;
  /// Visits the numbers of a message in order. Paths are built only if `named`. Text and arrays of more than 64 numbers
  /// (images, scans) are skipped; of an array of structures the first 64 are visited. Cost: linear in the message's
  /// bytes, whatever the definition says.
  /// @returns the fault of the message or its type; empty: none.
  std::string walk(std::string_view message, bool named, const Visit& visit) const;

 private:
  struct Field {
    std::string name;
    std::string type;
    bool array = false;
    std::size_t fixed = 0;  ///< elements of an array of fixed size; 0: the message gives the count
    int inner = -1;         ///< index of the type if it is neither a number nor text
  };
  struct Definition {
    std::vector<Field> fields;
    bool has_bytes = false;  ///< a message of it has bytes; only then is it read
  };

  static Field field_of(const std::string& type, const std::string& name);
  void find_inner_types(const std::map<std::string, int>& numbers);
  void find_bytes();
  class Walker;

  std::vector<Definition> definitions_;  ///< the outer one first
  RosWire wire_ = RosWire::kPacked;
};

/// One topic of a bag: its messages and, after decode(), its numbers.
class RosTopic {
 public:
  std::string type_name;
  RosType type;
  std::string unknown;                                        ///< why the type cannot be read; empty: it can
  std::vector<std::pair<std::string_view, double>> messages;  ///< bytes, time of reception [s]

  /// Decodes the numbers of all messages. A message that is damaged, or whose arrays differ in length from those of the
  /// first sound one, becomes NaN. Times: the header's time stamp, or without one the time of reception, minus start_s.
  void decode(double start_s);
  const std::vector<std::string>& names() const { return names_; }
  const std::vector<double>& times() const { return time_s_; }
  /// nullptr: there is no such field.
  const std::vector<double>* field(const std::string& name) const;
  /// The header's message counter; empty: there is none, or its last value equals its first.
  std::vector<double> counter() const;
  const std::string& error_text() const { return error_text_; }

 private:
  void append(const std::vector<double>& numbers, double received_s, double start_s);

  std::vector<std::string> names_;
  std::vector<std::vector<double>> columns_;
  std::vector<double> time_s_;
  std::string error_text_;
  bool decoded_ = false;
};

/// The common part of both kinds of bags after their containers have been opened.
class RosLog : public RawLog {
 public:
  RawColumn column(const std::string& name, const std::string& map_key) const override;
  std::vector<std::string> names() const override;
  std::vector<TopicSummary> topics() const override;
  std::vector<std::string> notes() const override { return notes_; }

 protected:
  using RawLog::RawLog;
  /// Must be called after all messages were added. @throws InputError: there is none.
  void start();

  mutable std::map<std::string, RosTopic> topics_;
  std::vector<std::string> notes_;

 private:
  double start_s_ = 0.0;
};

}  // namespace m100::lab::logs
