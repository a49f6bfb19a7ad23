// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/paper/paper_report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "firmware/model/paper.h"
#include "host_tests/lab/identify/paper/paper.h"
#include "host_tests/lab/logs/flight_log.h"
#include "host_tests/lab/logs/formats/mat.h"

namespace m100::lab::identify::paper {
namespace {

// The ranges of the authors' scripts: scale factors from 15 to 55 s (climb: 30 s), dynamics without 10 s at both ends.
constexpr double kScaleFrom_s = 15.0;
constexpr double kAttitudeTo_s = 55.0;
constexpr double kClimbTo_s = 30.0;
constexpr double kCutOff_s = 10.0;

std::vector<double> column(const logs::RawLog& log, const std::string& name, double offset) {
  std::vector<double> out = log.column("Experiment1." + name, name).values;
  for (double& value : out) {
    value += offset;
  }
  return out;
}

Record record(const logs::RawLog& log, const std::string& stick, const std::string& response) {
  return {column(log, "Vicon.t", 0.0), column(log, stick, -model::paper::kNeutral_vrc), column(log, response, 0.0)};
}

// Forward differences with the last one repeated, as in the authors' script for the scale factor of the climb.
Record differentiated(Record height) {
  const double period_s = (height.t_s.back() - height.t_s.front()) / static_cast<double>(height.t_s.size() - 1);
  for (std::size_t row = 0; row + 1 < height.response.size(); ++row) {
    height.response[row] = (height.response[row + 1] - height.response[row]) / period_s;
  }
  height.response.back() = height.response[height.response.size() - 2];
  return height;
}

Record moved(Record record, int samples) {
  const std::vector<double> stick = record.stick;
  for (std::size_t row = 0; row < stick.size(); ++row) {
    const auto from = static_cast<std::ptrdiff_t>(row) - samples;
    record.stick[row] =
        stick[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(from, 0, static_cast<std::ptrdiff_t>(row)))];
  }
  return record;
}

double period_of(const Record& one) {
  return (one.t_s.back() - one.t_s.front()) / static_cast<double>(one.t_s.size() - 1);
}

double scale_of(const Record& one, double to_s, int lag) { return scale_factor(one, lag, kScaleFrom_s, to_s); }

int lag_of(const Record& one) { return correlation_lag(one.stick, one.response, period_of(one)); }

// The authors' script prints a factor with six decimals, and the next script uses the printed value.
double as_printed(double scale) { return std::round(scale * 1e6) / 1e6; }

/// Adds the attitude dynamics of Table II, which the published flight does not give.
void add_attitude(Report& report, const std::string& axis, const Record& raw, int shift, double scale,
                  const std::array<double, 2>& printed_first, const model::paper::SecondOrder& printed_second) {
  const double to_s = raw.t_s.back() - kCutOff_s;
  const Record right = moved(raw, shift);
  const Dynamics first = first_order(raw, as_printed(scale), kCutOff_s, to_s);
  const Dynamics first_right = first_order(right, as_printed(scale), kCutOff_s, to_s);
  const Dynamics second = second_order(raw, as_printed(scale), kCutOff_s, to_s);
  const Dynamics second_right = second_order(right, as_printed(scale), kCutOff_s, to_s);
  const auto add = [&](const char* what, double paper, double reproduced, double aligned) {
    report.lines.push_back({axis + what, paper, reproduced, aligned, "no cut of the published flight gives it"});
  };
  add(", first order: time constant [s]", printed_first[0], first.time_constant_s, first_right.time_constant_s);
  add(", first order: gain", printed_first[1], first.gain, first_right.gain);
  add(", second order: natural frequency [rad/s]", printed_second.natural_frequency_rad_s,
      second.natural_frequency_rad_s, second_right.natural_frequency_rad_s);
  add(", second order: damping ratio", printed_second.damping_ratio, second.damping_ratio, second_right.damping_ratio);
  add(", second order: gain", printed_second.gain, second.gain, second_right.gain);
}

const char* kMap = R"(time = "Experiment1.Vicon.t"
[signals]
stick_roll = { column = "Experiment1.RCData.channel[2]", offset = -1024 }
attitude_roll = "Experiment1.rpy[1]"
)";

}  // namespace

std::string verdict(const ReproducedNumber& number) {
  if (!std::isfinite(number.paper)) {
    return "";
  }
  if (!std::isfinite(number.reproduced)) {
    return "no data published";
  }
  // Half a unit of the last printed digit: three digits of a factor, three decimals of the dynamics.
  const double half = number.paper < 0.001 ? 0.5e-6 : number.paper < 0.01 ? 0.5e-5 : 0.5e-3;
  return std::abs(number.reproduced - number.paper) <= half ? "reproduced" : "different: " + number.why;
}

Report reproduce(const std::string& pitch_roll_file, const std::string& height_file) {
  Report report;
  const auto pitch_roll = logs::open_mat(pitch_roll_file);
  const auto height = logs::open_mat(height_file);
  const logs::FlightLog aligned = logs::load(*pitch_roll, logs::parse_column_map(kMap, "the map of the paper's files"));
  report.stick_shift_samples = aligned.alignment.stick_shift_samples;
  report.evidence = aligned.alignment.evidence;
  const int shift = report.stick_shift_samples;

  const Record roll = record(*pitch_roll, "RCData.channel[2]", "rpy[1]");
  const Record pitch = record(*pitch_roll, "RCData.channel[1]", "rpy[2]");
  const Record climbed = differentiated(record(*height, "RCData.channel[3]", "Vicon.p[3]"));
  const Record climb = record(*height, "RCData.channel[3]", "Vicon.v[3]");
  const auto add = [&](const char* quantity, double paper, double raw, double right) {
    report.lines.push_back({quantity, paper, raw, right});
  };
  // The authors shift pitch by the lag that they found for roll.
  const int roll_lag = lag_of(roll);
  const int right_lag = lag_of(moved(roll, shift));
  add("lag of the roll response [samples]", std::nan(""), roll_lag, right_lag);
  add("scale roll [rad/count]", model::paper::kScaleRoll_rad_per_count.experiment,
      scale_of(roll, kAttitudeTo_s, roll_lag), scale_of(moved(roll, shift), kAttitudeTo_s, right_lag));
  add("scale pitch [rad/count]", model::paper::kScalePitch_rad_per_count.experiment,
      scale_of(pitch, kAttitudeTo_s, roll_lag), scale_of(moved(pitch, shift), kAttitudeTo_s, right_lag));
  const double scale = scale_of(climbed, kClimbTo_s, lag_of(climbed));
  const Record climbed_right = moved(climbed, shift);
  const double scale_right = scale_of(climbed_right, kClimbTo_s, lag_of(climbed_right));
  add("scale climb [m/s/count]", model::paper::kScaleClimb_m_s_per_count.experiment, scale, scale_right);

  const double to_s = climb.t_s.back() - kCutOff_s;
  const Dynamics first = first_order(climb, as_printed(scale), kCutOff_s, to_s);
  const Dynamics second = second_order(climb, as_printed(scale), kCutOff_s, to_s);
  const Record right = moved(climb, shift);
  const Dynamics first_right = first_order(right, as_printed(scale_right), kCutOff_s, to_s);
  const Dynamics second_right = second_order(right, as_printed(scale_right), kCutOff_s, to_s);
  add("climb, first order: time constant [s]", 0.334, first.time_constant_s, first_right.time_constant_s);
  add("climb, first order: gain", 1.118, first.gain, first_right.gain);
  add("climb, second order: natural frequency [rad/s]", model::paper::kClimbSecond.natural_frequency_rad_s,
      second.natural_frequency_rad_s, second_right.natural_frequency_rad_s);
  add("climb, second order: damping ratio", model::paper::kClimbSecond.damping_ratio, second.damping_ratio,
      second_right.damping_ratio);
  add("climb, second order: gain", model::paper::kClimbSecond.gain, second.gain, second_right.gain);
  add_attitude(report, "roll", roll, shift, scale_of(roll, kAttitudeTo_s, roll_lag),
               {model::paper::kRollFirst.time_constant_s, model::paper::kRollFirst.gain}, model::paper::kRollSecond);
  add_attitude(report, "pitch", pitch, shift, scale_of(pitch, kAttitudeTo_s, roll_lag),
               {model::paper::kPitchTimeConstantTable2_s, model::paper::kPitchFirst.gain}, model::paper::kPitchSecond);
  for (const auto& [axis, factors] : {std::pair{"roll [rad/count]", model::paper::kScaleRoll_rad_per_count},
                                      {"pitch [rad/count]", model::paper::kScalePitch_rad_per_count},
                                      {"yaw rate [rad/s/count]", model::paper::kScaleYawRate_rad_s_per_count},
                                      {"climb [m/s/count]", model::paper::kScaleClimb_m_s_per_count}}) {
    report.lines.push_back({"simulator's scale " + std::string(axis), factors.simulator, std::nan(""), std::nan("")});
  }
  return report;
}

void add_yaw(Report& report, const std::string& yaw_file) {
  const auto yaw = logs::open_mat(yaw_file);
  const int shift =
      logs::load(*yaw, logs::parse_column_map(kMap, "the map of the paper's files")).alignment.stick_shift_samples;
  // The stick is positive to the right, the odometry's rate to the left. The IMU's own stream has the stick's sign.
  const auto to_the_left = [](Record one) {
    for (double& counts : one.stick) {
      counts = -counts;
    }
    return one;
  };
  const Record odometry = to_the_left(record(*yaw, "RCData.channel[4]", "Vicon.w[3]"));
  const Record angle = differentiated(to_the_left(record(*yaw, "RCData.channel[4]", "rpy[3]")));
  Record imu = record(*yaw, "RCData.channel[4]", "IMU.w[3]");
  imu.response.resize(imu.t_s.size(), imu.response.back());  // the stream is some rows shorter
  const Record right = moved(odometry, shift);
  const Record angle_right = moved(angle, shift);
  const double scale = scale_of(angle, kAttitudeTo_s, lag_of(angle));
  const double scale_right = scale_of(angle_right, kAttitudeTo_s, lag_of(angle_right));
  const auto add = [&](const char* quantity, double paper, double raw, double aligned) {
    report.lines.push_back({quantity, paper, raw, aligned});
  };
  const auto fit = [](const Record& one, double factor) {
    return first_order(one, as_printed(factor), kCutOff_s, one.t_s.back() - kCutOff_s);
  };
  const Dynamics from_odometry = fit(odometry, scale);
  const Dynamics from_imu = fit(imu, scale);
  const Dynamics from_aligned = fit(right, scale_right);
  add("scale yaw rate [rad/s/count]", model::paper::kScaleYawRate_rad_s_per_count.experiment, scale, scale_right);
  report.lines.back().why = "equation (1) gives another factor on the published flight";
  add("yaw rate, equation: time constant [s]", model::paper::kYawRateFirst.time_constant_s,
      from_odometry.time_constant_s, from_aligned.time_constant_s);
  add("yaw rate, equation: gain", model::paper::kYawRateFirst.gain, from_odometry.gain, from_aligned.gain);
  add("yaw rate, Table II (IMU stream, 3 rows early): time constant [s]",
      model::paper::kYawRateFirstTable2.time_constant_s, from_imu.time_constant_s, from_aligned.time_constant_s);
  report.lines.back().why = "by a hundredth; its cut is not known";
  add("yaw rate, Table II (IMU stream, 3 rows early): gain", model::paper::kYawRateFirstTable2.gain, from_imu.gain,
      from_aligned.gain);
  const auto fit_second = [](const Record& one, double factor) {
    return second_order(one, as_printed(factor), kCutOff_s, one.t_s.back() - kCutOff_s);
  };
  const Dynamics second = fit_second(imu, scale);
  const Dynamics second_aligned = fit_second(right, scale_right);
  const model::paper::SecondOrder& printed = model::paper::kYawRateSecond;
  const auto add_second = [&](const char* what, double paper, double reproduced, double aligned) {
    add(what, paper, reproduced, aligned);
    report.lines.back().why = "its cut is not known";
  };
  add_second("yaw rate, second order: natural frequency [rad/s]", printed.natural_frequency_rad_s,
             second.natural_frequency_rad_s, second_aligned.natural_frequency_rad_s);
  add_second("yaw rate, second order: damping ratio", printed.damping_ratio, second.damping_ratio,
             second_aligned.damping_ratio);
  add_second("yaw rate, second order: gain", printed.gain, second.gain, second_aligned.gain);
}

}  // namespace m100::lab::identify::paper
