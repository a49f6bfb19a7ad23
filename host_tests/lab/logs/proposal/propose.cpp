// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/logs/proposal/propose.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>
#include <utility>
#include <vector>

#include "host_tests/lab/input_error.h"
#include "host_tests/lab/logs/proposal/dialects.h"
#include "host_tests/lab/logs/signal.h"
#include "host_tests/lab/logs/stream.h"
#include "host_tests/lab/printed.h"

namespace m100::lab::logs {
namespace {

class Proposer {
 public:
  explicit Proposer(const RawLog& log) : log_(log) {
    for (std::string& name : log.names()) {
      names_.insert(std::move(name));
    }
    topics_ = log.format().starts_with("ROS") ? log.topics() : std::vector<TopicSummary>{};
  }

  std::optional<Proposal> make() const {
    for (const Dialect& dialect : dialects()) {
      if (has(resolved(dialect.known_by)) && has(resolved(dialect.time))) {
        return written(dialect);
      }
    }
    return std::nullopt;
  }

 private:
  /// Replaces "<Imu>" in "<Imu>.x" by the first topic of that type; empty: there is none.
  std::string resolved(const std::string& column) const {
    if (column.empty() || column.front() != '<') {
      return column;
    }
    const std::size_t end = column.find('>');
    const std::string ending = "/" + column.substr(1, end - 1);
    const auto topic = std::find_if(topics_.begin(), topics_.end(),
                                    [&](const TopicSummary& one) { return one.type.ends_with(ending); });
    return topic == topics_.end() ? "" : topic->name + column.substr(end + 1);
  }

  bool has(const std::string& column) const { return !column.empty() && names_.count(column) > 0; }

  bool readable(const MapEntry& line) const {
    const std::string column = resolved(line.column);
    if (!has(column)) {
      return false;
    }
    try {
      return log_.column(column, line.signal).values.size() > 1;
    } catch (const InputError&) {
      return false;
    }
  }

  static std::string quoted(const std::string& text) {
    std::string out = "\"";
    for (const char c : text) {
      const auto byte = static_cast<unsigned char>(c);
      out += c == '"' || c == '\\'         ? std::string("\\") + c
             : byte < 0x20 || byte == 0x7F ? printed("\\u%04x", static_cast<unsigned>(byte))
                                           : std::string(1, c);
    }
    return out + "\"";
  }

  void write(const MapEntry& line, std::ostream& out) const {
    const std::string column = quoted(resolved(line.column));
    out << line.signal << " = ";
    line.more.empty() ? out << column << "\n" : out << "{ column = " << column << ", " << line.more << " }\n";
  }

  /// What may have flown the aircraft: the lines of a map, and the time in which it moves.
  struct Command {
    std::string what, lines;
    double moves_s = 0.0, logged_s = 0.0;
  };

  /// Measures for how long one of the columns differs from its median by more than 0.01: of full deflection for a
  /// stick, of a rad, rad/s or m/s for a set point. A stick that rests beside its middle does not move.
  void measure(const std::vector<std::string>& columns, Command& out) const {
    std::vector<bool> moves;
    double rate_hz = 1.0;
    for (const std::string& column : columns) {
      if (!readable({"", column})) {
        continue;
      }
      const RawColumn raw = log_.column(column, "");
      std::vector<double> finite = raw.values;
      std::erase_if(finite, [](double value) { return !std::isfinite(value); });
      const double rest = finite.empty() ? 0.0 : median(std::move(finite));
      moves.resize(std::max(moves.size(), raw.values.size()));
      for (std::size_t k = 0; k < raw.values.size(); ++k) {
        moves[k] = moves[k] || std::abs(raw.values[k] - rest) > 0.01;
      }
      rate_hz = std::max(summary_of("", "", raw.time_s, {}).rate_hz, 1e-3);
    }
    out.moves_s = static_cast<double>(std::count(moves.begin(), moves.end(), true)) / rate_hz;
    out.logged_s = static_cast<double>(moves.size()) / rate_hz;
  }

  /// The commands of DJI's generic set point. Its flag (axes[4]) says what they are: bits 6 and 7 are 0 for angles,
  /// bits 4 and 5 are 0 for a climb speed, bit 3 is 1 for a yaw rate. nullopt: there is no set point.
  std::optional<Command> setpoint() const {
    const std::string topic = "/dji_sdk/flight_control_setpoint_generic.axes[";
    if (!readable({"", topic + "4]"})) {
      return std::nullopt;
    }
    const double flag_value = median(log_.column(topic + "4]", "").values);
    const unsigned flag = flag_value >= 0.0 && flag_value < 256.0 ? static_cast<unsigned>(flag_value) : 0xFFU;
    const bool has_angles = (flag & 0xC0U) == 0;
    Command out{.what = "The set point (flag " + std::to_string(flag) +
                        (has_angles ? ")" : "; its horizontal commands are no angles: they cannot be mapped)"),
                .lines = {}};
    const auto command = [&](const char* signal, int axis) {
      out.lines += std::string(signal) + " = " + quoted(topic + std::to_string(axis) + "]") + "\n";
    };
    if (has_angles) {
      command("command_roll", 0);
      command("command_pitch", 1);
    }
    if ((flag & 0x30U) == 0) {
      command("command_climb", 2);
    }
    if ((flag & 0x08U) != 0) {
      command("command_yaw_rate", 3);
    }
    measure({topic + "0]", topic + "1]", topic + "2]", topic + "3]"}, out);
    return out;
  }

  /// The transmitter's sticks. nullopt: the log has none.
  std::optional<Command> sticks(const Dialect& dialect) const {
    const auto group = std::find_if(dialect.groups.begin(), dialect.groups.end(),
                                    [&](const Group& one) { return one.provides == "sticks" && is_readable(one); });
    if (group == dialect.groups.end()) {
      return std::nullopt;
    }
    Command out{.what = "The transmitter's sticks", .lines = {}};
    std::ostringstream lines;
    std::vector<std::string> columns;
    for (const MapEntry& line : group->lines) {
      write(line, lines);
      columns.push_back(resolved(line.column));
    }
    out.lines = lines.str();
    measure(columns, out);
    return out;
  }

  /// Maps, where a set point may have flown the aircraft, what moves it most of the time, and names the other as a
  /// comment. A pilot who flies moves his sticks for more than a tenth of the time: less is a touch, even if the set
  /// point does not move. @returns whether there is a set point.
  bool write_commands(const Dialect& dialect, std::ostream& out) const {
    std::optional<Command> taken = setpoint();
    if (!taken) {
      return false;
    }
    std::optional<Command> other = sticks(dialect);
    if (other && other->moves_s > std::max(taken->moves_s, 0.1 * other->logged_s)) {
      std::swap(taken, other);
    }
    const auto summary = [](const Command& one) {
      return "# " + one.what + printed(": moves for %.2f of %.2f s", one.moves_s, one.logged_s);
    };
    out << summary(*taken) << ".\n" << taken->lines;
    if (other) {
      out << summary(*other) << "; if it flew the aircraft, take instead:\n";
      std::istringstream lines(other->lines);
      for (std::string line; std::getline(lines, line);) {
        out << "# " << line << "\n";
      }
    }
    return true;
  }

  bool is_readable(const Group& group) const {
    return std::all_of(group.lines.begin(), group.lines.end(), [&](const MapEntry& line) { return readable(line); });
  }

  std::optional<Proposal> written(const Dialect& dialect) const {
    std::ostringstream out;
    out << "# Proposed by m100-lab logs: recognised " << dialect.name
        << ". Check the signs and units of every signal.\n";
    if (dialect.frame != "nwu_flu") {
      out << "frame = \"" << dialect.frame << "\"\n";
    }
    out << "time = " << quoted(resolved(dialect.time)) << "\n[signals]\n";
    std::set<std::string> given;
    if (write_commands(dialect, out)) {
      given.insert("sticks");
    }
    for (const Group& group : dialect.groups) {
      if (given.count(group.provides) == 0 && is_readable(group)) {
        given.insert(group.provides);
        for (const MapEntry& line : group.lines) {
          write(line, out);
        }
      }
    }
    std::ostringstream extra;
    for (const MapEntry& line : dialect.extra) {
      if (readable(line)) {
        write(line, extra);
      }
    }
    out << (extra.str().empty() ? "" : "[extra]\n" + extra.str());
    return given.empty() ? std::nullopt : std::optional(Proposal{dialect.name, out.str()});
  }

  const RawLog& log_;
  std::set<std::string> names_;
  std::vector<TopicSummary> topics_;
};

}  // namespace

std::optional<Proposal> propose(const RawLog& log) { return Proposer(log).make(); }

}  // namespace m100::lab::logs
