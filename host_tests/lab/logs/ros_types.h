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

/// How a message is laid out in bytes.
enum class RosWire {
  kPacked,  ///< ROS 1: little endian, no padding, strings by their length
  kCdr      ///< ROS 2: four bytes of head, primitives aligned to their size, strings with their NUL
};

/// The definition of a message type and of all types inside of it, from the text that a bag carries or, for ROS 2 bags
/// without one, from a few types that are known here: Imu, PoseStamped, PoseWithCovarianceStamped, Odometry,
/// QuaternionStamped, TransformStamped, TwistStamped, Vector3Stamped, Joy.
class RosType {
 public:
  RosType() = default;
  /// @param own the name of the outer type. @param text of ROS 1 or ROS 2.
  RosType(const std::string& own, const std::string& text, RosWire wire);
  /// nullptr where the type is not known here.
  static const char* known_definition(const std::string& type);

  using Visit = std::function<void(const std::string& path, double value)>;
  /// Visits the numbers of a message in order. Paths are made only if `named`.
  /// Arrays longer than 64 numbers (images, scans) are stepped over; so is text. Cost: linear in the message's bytes,
  /// whatever the definition says.
  /// @returns "" or what is wrong with the message or its type.
  std::string walk(std::string_view message, bool named, const Visit& visit) const;

 private:
  struct Field {
    std::string name;
    std::string type;
    bool array = false;
    std::size_t fixed = 0;  ///< elements of an array of fixed size; 0: the message says
    int inner = -1;         ///< index of the type where it is not a number or text
  };
  struct Definition {
    std::vector<Field> fields;
    bool has_bytes = false;  ///< some value lies inside, at some depth
  };

  static Field field_of(const std::string& type, const std::string& name);
  void find_inner_types(const std::map<std::string, int>& numbers);
  void find_bytes();
  class Walker;

  std::vector<Definition> definitions_;  ///< the outer one first
  RosWire wire_ = RosWire::kPacked;
};

/// One topic of a bag: its messages, and once it was asked for, its numbers.
class RosTopic {
 public:
  std::string type_name;
  RosType type;
  std::string unknown;                                        ///< why the type cannot be read; empty: it can
  std::vector<std::pair<std::string_view, double>> messages;  ///< bytes, time of reception [s]

  /// Numbers of all messages; a message that is damaged, or whose arrays have other lengths than the first one's, is
  /// NaN throughout. Times: the header's stamp, else the reception, less start_s.
  void decode(double start_s);
  const std::vector<std::string>& names() const { return names_; }
  const std::vector<double>& times() const { return time_s_; }
  /// nullptr: there is no such field.
  const std::vector<double>* field(const std::string& name) const;
  std::size_t damaged() const { return damaged_; }
  const std::string& complaint() const { return complaint_; }

 private:
  void complain(const std::string& wrong);
  void append(const std::vector<double>& numbers, double received_s, double start_s);

  std::vector<std::string> names_;
  std::vector<std::vector<double>> columns_;
  std::vector<double> time_s_;
  std::size_t damaged_ = 0;
  std::string complaint_;
  bool decoded_ = false;
};

/// What both kinds of bags are once their containers have been opened.
class RosLog : public RawLog {
 public:
  RawColumn column(const std::string& name, const std::string& asked_by) const override;
  std::vector<std::string> names() const override;
  std::vector<TopicSummary> topics() const override;
  std::vector<std::string> notes() const override { return notes_; }

 protected:
  using RawLog::RawLog;
  /// To be called once all messages are there. @throws InputError: there is none.
  void start();

  mutable std::map<std::string, RosTopic> topics_;
  std::vector<std::string> notes_;

 private:
  double start_s_ = 0.0;
};

}  // namespace m100::lab::logs
