// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/logs/flight_log.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "host_tests/lab/input_error.h"
#include "host_tests/lab/logs/alignment/rate_alignment.h"
#include "host_tests/lab/logs/alignment/sampling_clock.h"
#include "host_tests/lab/logs/force_check.h"
#include "host_tests/lab/logs/join.h"
#include "host_tests/lab/logs/no_such_column.h"
#include "host_tests/lab/logs/quaternion.h"
#include "host_tests/lab/logs/stream.h"
#include "host_tests/lab/logs/stretches.h"
#include "host_tests/lab/printed.h"

namespace m100::lab::logs {
namespace {

constexpr std::size_t kFewestSamples = 16;
constexpr double kSlowestSample_s = 1.0;  // slower: not a flight log, or its clock counts milliseconds

/// From the column's unit to the canonical one.
void convert(const ColumnRef& ref, std::vector<double>& values) {
  for (double& value : values) {
    value = ref.scale * (value + ref.offset);
  }
}

class Loader {
 public:
  Loader(const RawLog& raw, const ColumnMap& map, double period_s) : raw_(raw), map_(map) {
    log_.file = raw.file();
    log_.columns = map.file;
    log_.period_s = period_s;
  }

  FlightLog load() {
    read_clock();
    for (std::size_t i = 0; i < kSignals; ++i) {
      const auto signal = static_cast<Signal>(i);
      if (map_.signals[i] && signal != Signal::kSequence && !is_quaternion(signal)) {
        read_signal(signal, *map_.signals[i]);
      }
    }
    read_quaternion(Signal::kAttitudeQw, Signal::kAttitudeRoll, 3);
    read_quaternion(Signal::kCommandQw, Signal::kCommandRoll, 2);
    for (const auto& [name, ref] : map_.extra) {
      std::vector<std::uint8_t> unused(log_.size, 0);
      const Stream stream = tidy(stream_of(ref, "extra." + name, nullptr), ref.column, false);
      log_.extra[name] = resampled(stream, log_.start_s, log_.period_s, log_.size, unused);
    }
    const std::vector<std::string> damage = raw_.notes();
    log_.notes.insert(log_.notes.end(), damage.begin(), damage.end());
    fill_pauses(log_);
    note_gaps(log_);
    log_.notes.insert(log_.notes.end(), sampling_.notes().begin(), sampling_.notes().end());
    align_rates(log_);
    validate_force(log_);
    return std::move(log_);
  }

 private:
  void read_clock() {
    RawColumn clock = column(map_.time, map_.time.column, "time");
    clock_s_ = std::move(clock.values);
    convert(map_.time, clock_s_);
    counter_ = clock.sequence;
    if (const auto& mapped = map_.signals[static_cast<std::size_t>(Signal::kSequence)]) {
      counter_ = column(*mapped, mapped->column, "sequence").values;
    }
    if (counter_.size() != clock_s_.size()) {
      counter_.clear();
    }
    counter_ = unwrapped(counter_);
    arrival_s_ = clock_s_;
    clock_s_ = sampling_times(stream_name(map_.time.column), clock_s_, counter_, values_beside_clock());
    const std::vector<Stretch> own = stretches_of(clock_s_);
    set_back_ = own.empty() ? 0 : own.back().set_back;
    stretches_ = placed(own, kFewestSamples, log_.period_s);
    if (stretches_.size() > 1) {
      log_.notes.push_back(map_.time.column + ": pauses or is set in between; the log has " +
                           std::to_string(stretches_.size()) + " stretches: " + list_of(stretches_));
    }
    clock_s_ = continuous(clock_s_, own, stretches_);
    const Stream times = tidy({clock_s_, clock_s_, {}}, map_.time.column, true);
    if (times.values.size() < kFewestSamples) {
      throw InputError(raw_.file(), 0, map_.time.column,
                       "has only " + std::to_string(times.values.size()) + " samples");
    }
    log_.start_s = times.time_s.front();
    const double samples = (times.time_s.back() - log_.start_s) / log_.period_s;
    constexpr double kMaxSamples = 1e8;
    if (samples > kMaxSamples) {
      throw InputError(raw_.file(), 0, map_.time.column, "spans more than 10 days: is its unit really seconds?");
    }
    const double typical_s = (times.time_s.back() - log_.start_s) / static_cast<double>(times.values.size());
    if (typical_s > kSlowestSample_s) {
      throw InputError(raw_.file(), 0, map_.time.column,
                       "has " + std::to_string(typical_s) + " s between samples: is its unit really seconds?");
    }
    log_.size = static_cast<std::size_t>(std::floor(samples + 1e-6)) + 1;
    if (log_.size < kFewestSamples) {
      throw InputError(raw_.file(), 0, map_.time.column, "spans less than 0.2 s: is its unit really seconds?");
    }
    log_.gap.assign(log_.size, 0);
    log_.flights = flights_of(stretches_, raw_.file(), log_);
  }

  /// Puts times of another clock of the file onto the continuous one. @throws InputError if it is set back elsewhere.
  std::vector<double> on_log_clock(const std::vector<double>& time_s, const std::string& name) const {
    const std::vector<Stretch> own = stretches_of(time_s);
    if (!own.empty() && own.back().set_back != set_back_) {
      throw InputError(raw_.file(), raw_.line_of(own.back().begin), name,
                       "time runs backwards " + std::to_string(own.back().set_back) + " times, that of " +
                           map_.time.column + " " + std::to_string(set_back_) + " times");
    }
    return continuous(time_s, own, stretches_);
  }

  static std::string stream_name(const std::string& column) { return column.substr(0, column.find('.')); }

  /// The times of a stream's samples: if the format keeps times of arrival and these are bunched, they are spread.
  std::vector<double> sampling_times(const std::string& stream, const std::vector<double>& arrival_s,
                                     const std::vector<double>& counter, const std::vector<double>& values) {
    return raw_.has_times_of_arrival() ? sampling_.times(stream, arrival_s, counter, values) : arrival_s;
  }

  /// The values of the first mapped signal without a `time` key; empty: there is none, or it has a clock of its own.
  std::vector<double> values_beside_clock() const {
    for (std::size_t i = 0; i < kSignals; ++i) {
      const auto& ref = map_.signals[i];
      if (ref && static_cast<Signal>(i) != Signal::kSequence && ref->time.empty()) {
        RawColumn beside = column(*ref, ref->column, std::string(name_of(static_cast<Signal>(i))));
        return beside.time_s.empty() ? std::move(beside.values) : std::vector<double>{};
      }
    }
    return {};
  }

  static bool is_quaternion(Signal signal) { return signal >= Signal::kAttitudeQw && signal <= Signal::kCommandQz; }
  double turn(Signal signal) const { return map_.frame == Frame::kNedFrd ? sign_in_ned_frd(signal) : 1.0; }

  /// The stream resampled onto the log's grid; its gaps are marked for these signals.
  std::vector<double> on_grid(const Stream& stream, Signal first, int signals) {
    std::vector<std::uint8_t> gap(log_.size, 0);
    std::vector<double> grid = resampled(stream, log_.start_s, log_.period_s, log_.size, gap);
    std::vector<double> rows(stream.time_s.size());
    std::adjacent_difference(stream.time_s.begin(), stream.time_s.end(), rows.begin());
    for (int i = 0; i < signals && rows.size() > 1; ++i) {
      log_.row_s[offset(first, i)] = median({rows.begin() + 1, rows.end()});
    }
    if (std::find(gap.begin(), gap.end(), 1) == gap.end()) {
      return grid;
    }
    for (int i = 0; i < signals; ++i) {
      std::vector<std::uint8_t>& own = log_.signal_gap[offset(first, i)];
      own.resize(log_.size, 0);
      add_gaps(own, gap);
    }
    add_gaps(log_.gap, gap);
    return grid;
  }

  void read_signal(Signal signal, const ColumnRef& ref) {
    int shift = 0;
    Stream stream = stream_of(ref, std::string(name_of(signal)), &shift);
    for (double& value : stream.values) {
      value *= turn(signal);
    }
    stream = tidy(stream, ref.column, false);
    require_overlap(stream, ref.column);
    if (signal == Signal::kAttitudeYaw) {
      unwrap_angle(stream.values);
    }
    log_.of(signal) = on_grid(stream, signal, 1);
    if (signal <= Signal::kStickYaw && 1.5 * log_.row_s[signal] < log_.period_s && stream.values.size() > 1) {
      log_.of(signal) = period_means(stream, log_.start_s, log_.period_s, log_.size);  // keeps steps between samples
    }
    if (shift != 0 && signal <= Signal::kStickYaw) {
      log_.alignment.stick_shift_samples = shift;
    } else if (shift != 0 && signal >= Signal::kRateX && signal <= Signal::kRateZ) {
      log_.alignment.rate_shift_samples = shift;
    }
  }

  /// Reads the four parts of a quaternion, resamples them one by one, and writes the Euler angles: the first `angles`
  /// of roll, pitch and yaw, from `first_angle` on.
  void read_quaternion(Signal first, Signal first_angle, int angles) {
    if (!map_.signals[static_cast<std::size_t>(first)]) {
      return;
    }
    std::array<Stream, 4> parts;
    for (int i = 0; i < 4; ++i) {
      const Signal signal = offset(first, i);
      Stream& part = parts[static_cast<std::size_t>(i)];
      const ColumnRef& ref = *map_.signals[static_cast<std::size_t>(signal)];
      part = stream_of(ref, std::string(name_of(signal)), nullptr);
      for (double& value : part.values) {
        value *= turn(signal);
      }
      if (part.values.empty() || part.time_s != parts[0].time_s) {
        throw InputError(raw_.file(), 0, ref.column, "has another clock than the quaternion's first part");
      }
    }
    const std::string& column = map_.signals[static_cast<std::size_t>(first)]->column;
    const std::size_t wrong = make_continuous({&parts[0].values, &parts[1].values, &parts[2].values, &parts[3].values});
    if (2 * wrong >= parts[0].values.size()) {
      throw InputError(raw_.file(), 0, column, "is not a quaternion: its four parts are not of unit length");
    }
    std::array<std::vector<double>, 4> grid;
    for (std::size_t i = 0; i < 4; ++i) {
      const Stream part = tidy(parts[i], column, false);
      require_overlap(part, column);
      grid[i] = on_grid(part, first_angle, angles);
    }
    std::vector<std::vector<double>> out(3, std::vector<double>(log_.size));
    for (std::size_t k = 0; k < log_.size; ++k) {
      const std::array<double, 3> euler = euler_zyx({grid[0][k], grid[1][k], grid[2][k], grid[3][k]});
      for (std::size_t i = 0; i < 3; ++i) {
        out[i][k] = euler[i];
      }
    }
    unwrap_angle(out[2]);
    for (int i = 0; i < angles; ++i) {
      log_.of(offset(first_angle, i)) = std::move(out[static_cast<std::size_t>(i)]);
    }
  }

  /// One column of the log. @throws InputError naming the map's line if the log has no column of that name.
  RawColumn column(const ColumnRef& ref, const std::string& name, const std::string& key) const {
    try {
      return raw_.column(name, key);
    } catch (const NoSuchColumn& wrong) {
      throw InputError(map_.file, ref.line, key, wrong.what());
    }
  }

  /// Times and scaled values of one column. @param shift receives, if not null, the shift in samples from its counter.
  Stream stream_of(const ColumnRef& ref, const std::string& key, int* shift) {
    RawColumn column = this->column(ref, ref.column, key);
    convert(ref, column.values);
    if (!ref.time.empty()) {
      RawColumn clock = this->column(ref, ref.time, key + ".time");
      column.time_s = std::move(clock.values);
      column.sequence = clock.sequence.empty() ? std::move(column.sequence) : std::move(clock.sequence);
      convert(map_.time, column.time_s);
    }
    if (!ref.sequence.empty()) {
      column.sequence = this->column(ref, ref.sequence, key + ".sequence").values;
    }
    Stream stream{.time_s = clock_s_, .values = std::move(column.values), .after_spoilt = {}};
    leave_out_last_state(stream, ref.column);
    if (!column.time_s.empty()) {
      const bool is_clock = column.time_s == arrival_s_;
      const std::string& clock = ref.time.empty() ? ref.column : ref.time;
      stream.time_s =
          is_clock
              ? clock_s_
              : on_log_clock(sampling_times(stream_name(clock), column.time_s, column.sequence, stream.values), clock);
    } else if (!column.sequence.empty() && !counter_.empty()) {
      stream.time_s = times_by_counter(unwrapped(column.sequence), stream.values.size(), key, shift);
    }
    if (stream.time_s.size() != stream.values.size()) {
      throw InputError(raw_.file(), 0, ref.column,
                       "has " + std::to_string(stream.values.size()) + " samples, its clock " +
                           std::to_string(stream.time_s.size()) + " (key " + key + ")");
    }
    return stream;
  }

  /// A recursion of N steps has N + 1 states: the last one has no time in a clock of N samples, and is left out.
  void leave_out_last_state(Stream& stream, const std::string& column) {
    if (stream.values.size() != clock_s_.size() + 1) {
      return;
    }
    if (std::exchange(has_last_states_, true) == false) {
      log_.notes.push_back(column + ": has " + std::to_string(stream.values.size()) + " samples and the clock " +
                           std::to_string(clock_s_.size()) +
                           ": taken as the N + 1 states of N steps; the last state, which has no time, is left out");
    }
    stream.values.pop_back();
  }

  /// @throws InputError if the stream and the clock, the map's time column, have no time in common.
  void require_overlap(const Stream& stream, const std::string& column) const {
    const double end_s = log_.start_s + static_cast<double>(log_.size) * log_.period_s;
    if (stream.time_s.front() <= end_s && stream.time_s.back() >= log_.start_s) {
      return;
    }
    throw InputError(raw_.file(), 0, column,
                     printed("does not overlap with the clock: its times are %.2f to %.2f s, those of ",
                             stream.time_s.front(), stream.time_s.back()) +
                         map_.time.column + printed(" are %.2f to %.2f s", log_.start_s, end_s));
  }

  /// The times of the messages with the numbers `own` on the log's clock, linearly inter- and extrapolated.
  std::vector<double> times_by_counter(std::vector<double> own, std::size_t count, const std::string& key, int* shift) {
    if (own.size() != count && count == counter_.size()) {
      // The stream was resampled to the clock's rows, but its first message was put into row 0. So the message in
      // row k is as many messages after the stream's first as the clock's row k is after the clock's first.
      const double first = own.front();
      own.resize(count);
      std::transform(counter_.begin(), counter_.end(), own.begin(),
                     [&](double number) { return first + number - counter_.front(); });
    }
    own.resize(std::min(own.size(), count));
    std::vector<double> moved;
    for (std::size_t k = 0; k < std::min(own.size(), counter_.size()); ++k) {
      if (std::isfinite(own[k] - counter_[k])) {
        moved.push_back(own[k] - counter_[k]);
      }
    }
    if (moved.empty()) {
      throw InputError(raw_.file(), 0, key, "has a message counter without numbers");
    }
    const int samples = static_cast<int>(std::lround(median(moved)));
    log_.alignment.evidence = "sequence";
    if (shift != nullptr) {
      *shift = samples;
    }
    if (samples != 0) {
      log_.notes.push_back(key + ": moved by " + std::to_string(samples) + " samples to match the message counters");
    }
    const Stream table = tidy({counter_, clock_s_, {}}, "sequence", true);
    if (table.values.size() < 2) {
      throw InputError(raw_.file(), 0, key, "has a message counter that does not count");
    }
    std::vector<double> times;
    times.reserve(own.size());
    std::size_t hint = 0;
    for (const double number : own) {
      times.push_back(interpolate(table.time_s, table.values, number, hint));
    }
    return times;
  }

  /// @throws InputError: no usable sample, or time runs backwards (it cannot be known which part of the log is wrong).
  Stream tidy(const Stream& stream, const std::string& name, bool is_clock) {
    StreamDefects untidy;
    std::size_t backwards = 0;
    Stream out = without_defects(stream, untidy, backwards);
    if (backwards < stream.time_s.size()) {
      throw InputError(raw_.file(), raw_.line_of(backwards), name, "time runs backwards");
    }
    if (out.values.empty()) {
      throw InputError(raw_.file(), 0, name, "has no usable sample");
    }
    if (is_clock && untidy.repeated > 0) {
      log_.notes.push_back(name + ": " + std::to_string(untidy.repeated) +
                           " repeated time stamps; the first sample of each is kept");
    }
    if (untidy.spoilt > 0) {
      log_.gap_notes.push_back(name + ": " + std::to_string(untidy.spoilt) + " of " +
                               std::to_string(stream.time_s.size()) + " samples cannot be used");
    }
    return out;
  }

  const RawLog& raw_;
  const ColumnMap& map_;
  SamplingClock sampling_;
  std::vector<double> arrival_s_;  ///< of the map's clock, as logged
  std::vector<double> clock_s_;    ///< of the map's clock, as sampled and continuous
  std::vector<Stretch> stretches_;
  std::size_t set_back_ = 0;  ///< how often the map's clock is set back
  std::vector<double> counter_;
  bool has_last_states_ = false;  ///< a column has one sample more than the clock
  FlightLog log_;
};

}  // namespace

std::size_t FlightLog::index_of(double time) const {
  const double k = std::ceil((time - start_s) / period_s - 1e-6);
  return static_cast<std::size_t>(std::clamp(k, 0.0, static_cast<double>(size)));
}

FlightLog load(const RawLog& raw, const ColumnMap& map, double period_s) { return Loader(raw, map, period_s).load(); }

FlightLog load(const std::string& file, const std::string& columns, double period_s) {
  const ColumnMap map = read_column_map(columns);
  return load(*open_log(file), map, period_s);
}

}  // namespace m100::lab::logs
