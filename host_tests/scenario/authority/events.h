// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/companion/files/text/json.h"

namespace m100::authority {

/// One line of the autopilot's --events.
struct Event {
  double t_s = 0.0;
  std::string what;
  std::string name;
  double value = 0.0;
};

/// Reads the autopilot's events while they are written. The only source for who has control.
class Events {
 public:
  explicit Events(std::string path) : path_(std::move(path)) {}
  ~Events();
  Events(const Events&) = delete;
  Events& operator=(const Events&) = delete;

  /// Reads the new lines. @returns true if there were some.
  bool poll();

  const std::vector<Event>& all() const { return events_; }
  /// The summary, which is the last line; null until it is written.
  const Json& summary() const { return summary_; }
  /// The time of the last line.
  double now_s() const { return now_s_; }
  /// Time of the first such event; infinity if there is none.
  double first_s(std::string_view what, std::string_view name) const;
  /// Whether the client had control, or its virtual sticks flew, at that time.
  bool client_flew_at(double t_s) const;
  /// Start of the last uninterrupted control by the transmitter; infinity if it does not have control.
  double transmitter_for_good_s() const;
  /// First time not before t_s at which the transmitter had control; infinity if it never had.
  double transmitter_from_s(double t_s) const;
  /// Number of commands that move the aircraft and were taken before that time.
  std::size_t commands_taken_before(double t_s) const;
  /// Largest distance [m] from its position at that time, until the end.
  double farthest_from_m(double t_s) const;

 private:
  struct Change {
    double t_s;
    bool to_transmitter;
  };
  struct Truth {
    double t_s;
    double x_m;
    double y_m;
    double z_m;
  };
  void take_line(std::string_view line);

  std::string path_;
  int descriptor_ = -1;
  std::string rest_;
  std::vector<Event> events_;
  std::vector<Change> changes_;
  std::vector<Truth> truths_;
  Json summary_;
  double now_s_ = 0.0;
};

inline constexpr double kNever_s = std::numeric_limits<double>::infinity();

}  // namespace m100::authority
