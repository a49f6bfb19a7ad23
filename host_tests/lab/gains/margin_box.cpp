// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/gains/margin_box.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <numbers>
#include <stdexcept>
#include <utility>

namespace m100::lab::gains {
namespace {

using Complex = std::complex<double>;
constexpr double kLowest_rad_s = 0.3;  ///< the loop gain is above 100 there, and the sensitivity below 0.01
constexpr double kDelayStep_s = 0.01;
constexpr int kDelaySteps = 20;

Range relative(const companion::Intervals& intervals, const char* key, double value, Range least) {
  const auto found = intervals.find(key);
  if (found == intervals.end() || !(value > 0.0)) {
    return least;
  }
  return {std::min(least.low, found->second.low / value), std::max(least.high, found->second.high / value)};
}

Range absolute(const companion::Intervals& intervals, const char* key, Range least) {
  const auto found = intervals.find(key);
  return found == intervals.end()
             ? least
             : Range{std::min(least.low, found->second.low), std::max(least.high, found->second.high)};
}

struct Peak {
  double sensitivity = 0.0, gain = 1.0, at_rad_s = 0.0;
};

/// The largest sensitivity over the gains g, where |1 + g L| is least.
Peak peak_at(Complex loop, const Range& gain, double at_rad_s) {
  const double g = std::clamp(-loop.real() / std::max(std::norm(loop), 1e-300), gain.low, gain.high);
  return {1.0 / std::abs(1.0 + g * loop), g, at_rad_s};
}

/// Phase that 1 + g L turns through from the lowest frequency to the highest. A whole turn is counted where the line
/// from one point to the next crosses the negative real axis.
double turned(const std::vector<Complex>& loop, double gain) {
  double turns = 0.0;
  Complex before = 1.0 + gain * loop.front();
  for (const Complex& at : loop) {
    const Complex now = 1.0 + gain * at;
    const double side = now.imag() < 0.0 ? 1.0 : -1.0;
    if ((before.imag() < 0.0) != (now.imag() < 0.0) &&
        side * (now.real() * before.imag() - before.real() * now.imag()) < 0.0) {
      turns += side;
    }
    before = now;
  }
  return 2.0 * std::numbers::pi * turns + std::arg(before) - std::arg(1.0 + gain * loop.front());
}

const char* word(Axis axis) { return axis == Axis::kX ? "x" : "y"; }

constexpr std::size_t kCoordinates = 4;

/// A step inside the box: a share of the range of frequency, damping or delay, or the pose a tick older or younger.
BoxPoint moved(BoxPoint at, std::size_t coordinate, double step, const AxisBox& box, std::size_t max_age_ticks) {
  const std::array numbers{&at.frequency, &at.damping, &at.delay_s};
  const std::array ranges{&box.frequency, &box.damping, &box.delay_s};
  if (coordinate < numbers.size()) {
    const Range& range = *ranges.at(coordinate);
    double& number = *numbers.at(coordinate);
    number = std::clamp(number + step * (range.high - range.low), range.low, range.high);
    return at;
  }
  std::size_t& age = at.timing.pose_age_ticks;
  age = step > 0.0 ? std::min(age + 1, max_age_ticks) : std::max(age, std::size_t(1)) - 1;
  return at;
}

/// Takes a larger peak and its place, or the first place where the loop is unstable.
void add_peak(const BoxPoint& point, const Peak& peak, bool stable, WorstMargins& out) {
  if (peak.sensitivity > out.peak_sensitivity || (!stable && out.stable)) {
    out.peak_sensitivity = std::max(out.peak_sensitivity, peak.sensitivity);
    out.at_peak = point;
    out.at_peak.gain = peak.gain;
    out.at_peak.at_rad_s = peak.at_rad_s;
  }
  out.stable = out.stable && stable;
}

void add_delay(const BoxPoint& unstable, double gain, WorstMargins& out) {
  const double margin_s = unstable.timing.extra_delay_s - kDelayStep_s;
  if (margin_s < out.delay_margin_s) {
    out.delay_margin_s = margin_s;
    out.at_delay = unstable;
    out.at_delay.gain = gain;
  }
}

}  // namespace

std::string BoxPoint::text() const {
  char out[120], at[40] = "";
  std::snprintf(out, sizeof out, ": gain x %.2f, frequency x %.2f, damping %.2f, delay %.0f ms", gain, frequency,
                damping, 1e3 * (delay_s + timing.extra_delay_s));
  if (at_rad_s > 0.0) {
    std::snprintf(at, sizeof at, ", at %.1f rad/s", at_rad_s);
  }
  return structure + ", " + word(axis) + ", " + words(timing) + out + at;
}

std::string WorstMargins::peak_text() const {
  char out[80];
  std::snprintf(out, sizeof out, "%speak sensitivity %.2f", stable ? "" : "UNSTABLE somewhere, ", peak_sensitivity);
  return std::string(out) + " (" + at_peak.text() + ")";
}

std::string WorstMargins::delay_text() const {
  char out[80];
  const bool found = !at_delay.structure.empty();
  std::snprintf(out, sizeof out, "delay margin %s%.0f ms", found ? "" : "at least ", 1e3 * delay_margin_s);
  return out + (found ? " (" + at_delay.text() + ")" : std::string());
}

AxisBox axis_box(const model::StickAxis& axis, const companion::Intervals& intervals) {
  AxisBox out;
  out.gain = relative(intervals, "scale_rad_per_count", axis.scale_per_count, out.gain);
  out.frequency = relative(intervals, "natural_frequency_rad_s", axis.natural_frequency_rad_s, out.frequency);
  out.damping = absolute(intervals, "damping_ratio", {axis.damping_ratio - 0.1, axis.damping_ratio + 0.1});
  out.damping.low = std::max(out.damping.low, 0.0);
  out.delay_s =
      absolute(intervals, "transport_delay_s", {axis.transport_delay_s - 0.01, axis.transport_delay_s + 0.01});
  out.delay_s.low = std::max(out.delay_s.low, 0.0);
  return out;
}

std::vector<OpenStructure> open_structures(const companion::VehicleFile& file) {
  const auto of = [&](const char* section) {
    const auto found = file.intervals.find(section);
    return found == file.intervals.end() ? companion::Intervals{} : found->second;
  };
  const OpenStructure own{
      .name = "its own structure",
      .vehicle = file.vehicle,
      .box = {axis_box(file.vehicle.pitch, of("axis.pitch")), axis_box(file.vehicle.roll, of("axis.roll"))}};
  std::vector<OpenStructure> out{own};
  std::array<std::size_t, 2> count{};
  for (const companion::Rival& rival : file.rivals) {
    const std::size_t axis = rival.axis == "pitch" ? 0 : 1;
    const std::size_t place = ++count[axis];
    while (out.size() <= place) {
      out.push_back(own);
      out.back().name = "rival " + std::to_string(out.size() - 1);
    }
    OpenStructure& into = out[place];
    (axis == 0 ? into.vehicle.pitch : into.vehicle.roll) = rival.numbers;
    into.box[axis] = axis_box(rival.numbers, rival.intervals);
  }
  return out;
}

MarginBox::MarginBox(std::vector<OpenStructure> structures, int points) : structures_(std::move(structures)) {
  for (std::size_t k = 0; k < structures_.size(); ++k) {
    for (const Axis axis : {Axis::kX, Axis::kY}) {
      if (attitude_of(structures_[k].vehicle, axis).is_first_order()) {
        throw std::domain_error("an axis of first order: the margins over a box need natural_frequency_rad_s");
      }
      for (const LoopTiming& timing : {kVirtualRcTiming, kMovementTiming}) {
        Case one{.structure = k, .axis = axis, .timing = timing};
        const double highest = std::numbers::pi / (0.01 * static_cast<double>(timing.command_ticks));
        for (int i = 0; i <= points; ++i) {
          one.frequencies_rad_s.push_back(kLowest_rad_s * std::pow(highest / kLowest_rad_s, double(i) / points));
        }
        add_plants(one);
        cases_.push_back(std::move(one));
      }
    }
  }
}

/// The system's responses from or to its 3 times command_ticks measurements, by measurement and frequency.
Eigen::MatrixXcd MarginBox::responses(const Case& one, const LiftedSystem& system) {
  Eigen::MatrixXcd out(3 * static_cast<Eigen::Index>(one.timing.command_ticks),
                       static_cast<Eigen::Index>(one.frequencies_rad_s.size()));
  for (Eigen::Index k = 0; k < out.cols(); ++k) {
    const double w = one.frequencies_rad_s[static_cast<std::size_t>(k)];
    const double period_s = 0.01 * static_cast<double>(one.timing.command_ticks);
    const Eigen::MatrixXcd at = system.response(std::polar(1.0, w * period_s));
    out.col(k) = Eigen::Map<const Eigen::VectorXcd>(at.data(), at.size());
  }
  return out;
}

model::Vehicle MarginBox::vehicle_at(const Case& one, const BoxPoint& point) const {
  model::Vehicle vehicle = structures_[one.structure].vehicle;
  model::StickAxis& axis = one.axis == Axis::kX ? vehicle.pitch : vehicle.roll;
  axis.natural_frequency_rad_s *= point.frequency;
  axis.damping_ratio = point.damping;
  axis.transport_delay_s = point.delay_s;
  return vehicle;
}

Eigen::MatrixXcd MarginBox::responses(const Case& one, const BoxPoint& point) const {
  return responses(one, lifted_aircraft(vehicle_at(one, point), one.axis, point.timing));
}

void MarginBox::add_plants(Case& one) {
  const AxisBox& box = box_of(one);
  const OpenStructure& structure = structures_[one.structure];
  const model::StickAxis& axis = attitude_of(structure.vehicle, one.axis);
  const std::size_t age = one.timing.pose_age_ticks;
  BoxPoint point{.structure = structure.name, .axis = one.axis, .timing = one.timing};
  const auto add = [&](std::vector<Plant>& to) { to.push_back({.of = point, .response = responses(one, point)}); };
  for (const double frequency : {1.0, box.frequency.low, box.frequency.high}) {
    point.frequency = frequency;
    point.damping = axis.damping_ratio;
    point.delay_s = axis.transport_delay_s;
    for (int k = 0; k <= kDelaySteps; ++k) {
      point.timing.extra_delay_s = k * kDelayStep_s;
      add(one.corners);
    }
    point.timing = one.timing;
    for (const double damping : {box.damping.low, axis.damping_ratio, box.damping.high}) {
      point.damping = damping;
      for (const double delay_s : {box.delay_s.low, axis.transport_delay_s, box.delay_s.high}) {
        point.delay_s = delay_s;
        for (const std::size_t pose_age : {std::size_t(0), age, 2 * age}) {
          point.timing.pose_age_ticks = pose_age;
          add(one.box);
        }
      }
    }
    point.timing = one.timing;
  }
}

const MarginBox::Law& MarginBox::law_of(const Case& one, Laws& laws) {
  std::optional<Law>& law = laws.made[(one.axis == Axis::kX ? 0U : 1U) + (one.timing.by_sticks ? 2U : 0U)];
  if (!law) {
    law.emplace(Law{.controller = FlownController(laws.believed, one.axis, one.timing), .response = {}});
    law->response = responses(one, *law->controller.lifted);
  }
  return *law;
}

/// The open loop of one law with the plants of a case, at the case's frequencies.
class MarginBox::CaseLoop {
 public:
  /// @param stick FlownController::stick_gain() of the plants
  /// @param nominal of a plant whose closed loop is stable: another loop is stable if it turns by the same phase
  CaseLoop(const Eigen::MatrixXcd& law, double stick, const Eigen::MatrixXcd& nominal)
      : law_(law), stick_(stick), loop_(static_cast<std::size_t>(law.cols())) {
    open(nominal);
    turned_ = turned(loop_, 1.0);
    start_ = loop_.front();
  }

  void open(const Eigen::MatrixXcd& plant) {
    Eigen::Map<Eigen::RowVectorXcd>(loop_.data(), law_.cols()) = -stick_ * law_.cwiseProduct(plant).colwise().sum();
  }
  bool is_stable(double gain) const {
    const double begun = std::arg((1.0 + gain * loop_.front()) / (1.0 + start_));
    return std::abs(begun + turned(loop_, gain) - turned_) < 0.5 * std::numbers::pi;
  }
  /// A gain with which the closed loop is unstable: as identified, or an end of the range.
  std::optional<double> unstable_gain(const Range& range) const {
    for (const double gain : {1.0, range.low, range.high}) {
      if (!is_stable(gain)) {
        return gain;
      }
    }
    return {};
  }
  /// The largest sensitivity, with its gain and frequency.
  Peak peak(const Range& gain, const std::vector<double>& frequencies_rad_s) const {
    Peak out;
    for (std::size_t k = 0; k < loop_.size(); ++k) {
      const Peak one = peak_at(loop_[k], gain, frequencies_rad_s[k]);
      out = one.sensitivity > out.sensitivity ? one : out;
    }
    return out;
  }

 private:
  const Eigen::MatrixXcd& law_;
  double stick_;
  std::vector<Complex> loop_;
  double turned_ = 0.0;
  Complex start_;
};

MarginBox::CaseLoop MarginBox::loop_of(const Case& one, const Law& law) const {
  const model::StickAxis& axis = attitude_of(structures_[one.structure].vehicle, one.axis);
  return {law.response, law.controller.stick_gain(axis), one.corners.front().response};
}

void MarginBox::add_case(const Case& one, const Law& law, Extent extent, WorstMargins& out) const {
  CaseLoop loop = loop_of(one, law);
  const Range gain = extent == Extent::kNominal ? Range{1.0, 1.0} : box_of(one).gain;
  for (const Plant& plant : extent == Extent::kBox || extent == Extent::kBoxPeak ? one.box : one.corners) {
    if (extent == Extent::kNominal && plant.of.frequency != 1.0) {
      continue;
    }
    loop.open(plant.response);
    const std::optional<double> unstable = loop.unstable_gain(gain);
    if (plant.of.timing.extra_delay_s == 0.0) {
      add_peak(plant.of, loop.peak(gain, one.frequencies_rad_s), !unstable, out);
      out.points += one.frequencies_rad_s.size();
    } else if (unstable) {
      add_delay(plant.of, *unstable, out);
    }
  }
}

/// Adds the delay margin of the box. Only aircraft with the largest delay are asked: with less, more may be added.
void MarginBox::add_box_delay(const Case& one, const Law& law, WorstMargins& out) const {
  const AxisBox& box = box_of(one);
  CaseLoop loop = loop_of(one, law);
  for (const Plant& plant : one.box) {
    BoxPoint late = plant.of;
    for (int k = 1; late.delay_s == box.delay_s.high && k * kDelayStep_s < out.delay_margin_s + 0.5 * kDelayStep_s;
         ++k) {
      late.timing.extra_delay_s = k * kDelayStep_s;
      loop.open(responses(one, late));
      if (const std::optional<double> unstable = loop.unstable_gain(box.gain)) {
        add_delay(late, *unstable, out);
      }
    }
  }
}

/// Refines the worst point of the grid: steps of a share of the box in one coordinate after the other, each taken if
/// the sensitivity becomes larger, then steps of half the size; at last the same in frequency.
void MarginBox::refine(const Case& one, const Law& law, WorstMargins& out) const {
  const AxisBox& box = box_of(one);
  CaseLoop loop = loop_of(one, law);
  const auto evaluate = [&](const BoxPoint& at) {
    loop.open(responses(one, at));
    add_peak(at, loop.peak(box.gain, one.frequencies_rad_s), !loop.unstable_gain(box.gain), out);
    out.points += one.frequencies_rad_s.size();
  };
  for (double share = 0.25; share > 0.01; share *= 0.5) {
    for (std::size_t coordinate = 0; coordinate < kCoordinates; ++coordinate) {
      for (const double step : {-share, share}) {
        evaluate(moved(out.at_peak, coordinate, step, box, 2 * one.timing.pose_age_ticks));
      }
    }
  }
  const FlownLoop flown(law.controller, vehicle_at(one, out.at_peak), one.axis, out.at_peak.timing);
  for (double step = 0.02; step > 1e-4; step *= 0.5) {
    for (const double factor : {1.0 - step, 1.0 + step}) {
      const double at_rad_s = std::min(factor * out.at_peak.at_rad_s, one.frequencies_rad_s.back());
      add_peak(out.at_peak, peak_at(-flown.response(at_rad_s), box.gain, at_rad_s), true, out);
      ++out.points;
    }
  }
}

WorstMargins MarginBox::worst(Laws& laws, Extent extent, const BoxSelection& only) const {
  WorstMargins out{.delay_margin_s = kDelayStep_s * kDelaySteps};
  const Case* worst_case = nullptr;
  for (const Case& one : cases_) {
    if (only.structure.value_or(one.structure) != one.structure || only.axis.value_or(one.axis) != one.axis ||
        only.by_sticks.value_or(one.timing.by_sticks) != one.timing.by_sticks) {
      continue;
    }
    const Law& law = law_of(one, laws);
    const BoxPoint& nominal = one.corners.front().of;
    if (!FlownLoop(law.controller, structures_[one.structure].vehicle, one.axis, one.timing).closed_is_stable()) {
      return {.stable = false, .peak_sensitivity = 1e9, .at_peak = nominal, .at_delay = nominal};
    }
    const double before = out.peak_sensitivity;
    add_case(one, law, extent, out);
    if (extent == Extent::kBox) {
      add_box_delay(one, law, out);
    }
    worst_case = out.peak_sensitivity > before ? &one : worst_case;
  }
  if (out.stable && worst_case != nullptr && (extent == Extent::kBox || extent == Extent::kBoxPeak)) {
    refine(*worst_case, law_of(*worst_case, laws), out);
  }
  return out;
}

}  // namespace m100::lab::gains
