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

/// Least |1 + g L| over the gains g in [low, high].
double nearest(Complex loop, double low, double high) {
  const double at = std::clamp(-loop.real() / std::max(std::norm(loop), 1e-300), low, high);
  return std::abs(1.0 + at * loop);
}

/// Phase that 1 + g L turns through from the lowest frequency to the highest.
double turned(const std::vector<Complex>& loop, double gain) {
  double sum = 0.0;
  for (std::size_t k = 1; k < loop.size(); ++k) {
    sum += std::arg((1.0 + gain * loop[k]) / (1.0 + gain * loop[k - 1]));
  }
  return sum;
}

const char* word(Axis axis) { return axis == Axis::kX ? "x" : "y"; }

/// The open loop of one law with the plants of a case, at the case's frequencies.
class CaseLoop {
 public:
  /// @param stick FlownController::stick_gain() of the plant
  CaseLoop(const Eigen::MatrixXcd& law, double stick)
      : law_(law), stick_(stick), loop_(static_cast<std::size_t>(law.cols())) {}

  void open(const Eigen::MatrixXcd& plant) {
    Eigen::Map<Eigen::RowVectorXcd>(loop_.data(), law_.cols()) = -stick_ * law_.cwiseProduct(plant).colwise().sum();
  }
  /// Takes this loop, whose closed loop is stable, as reference: another loop is stable if it turns by the same phase.
  void set_stable() {
    turned_ = turned(loop_, 1.0);
    start_ = loop_.front();
  }
  bool is_stable(double gain) const {
    const double begun = std::arg((1.0 + gain * loop_.front()) / (1.0 + start_));
    return std::abs(begun + turned(loop_, gain) - turned_) < 0.5 * std::numbers::pi;
  }
  double peak_sensitivity(const Range& gain) const {
    double least = 1e9;
    for (const Complex value : loop_) {
      least = std::min(least, nearest(value, gain.low, gain.high));
    }
    return 1.0 / least;
  }

 private:
  const Eigen::MatrixXcd& law_;
  double stick_;
  std::vector<Complex> loop_;
  double turned_ = 0.0;
  Complex start_;
};

}  // namespace

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

MarginBox::Plant MarginBox::plant(const Case& one, double frequency, double damping, double delay_s, int pose_age,
                                  double extra_s) const {
  model::Vehicle vehicle = structures_[one.structure].vehicle;
  model::StickAxis& axis = one.axis == Axis::kX ? vehicle.pitch : vehicle.roll;
  axis.natural_frequency_rad_s *= frequency;
  axis.damping_ratio = damping;
  axis.transport_delay_s = delay_s;
  LoopTiming timing = one.timing;
  timing.pose_age_ticks = static_cast<std::size_t>(pose_age);
  timing.extra_delay_s = extra_s;
  return {.frequency = frequency,
          .damping = damping,
          .delay_s = delay_s,
          .pose_age_ticks = pose_age,
          .extra_delay_s = extra_s,
          .response = responses(one, lifted_aircraft(vehicle, one.axis, timing))};
}

void MarginBox::add_plants(Case& one) {
  const AxisBox& box = structures_[one.structure].box[one.axis == Axis::kX ? 0 : 1];
  const model::StickAxis& axis = attitude_of(structures_[one.structure].vehicle, one.axis);
  const int age = static_cast<int>(one.timing.pose_age_ticks);
  for (const double frequency : {1.0, box.frequency.low, box.frequency.high}) {
    for (int k = 0; k <= kDelaySteps; ++k) {
      one.corners.push_back(plant(one, frequency, axis.damping_ratio, axis.transport_delay_s, age, k * kDelayStep_s));
    }
    for (const double damping : {box.damping.low, axis.damping_ratio, box.damping.high}) {
      for (const double delay_s : {box.delay_s.low, axis.transport_delay_s, box.delay_s.high}) {
        for (const int pose_age : {0, age, 2 * age}) {
          one.box.push_back(plant(one, frequency, damping, delay_s, pose_age, 0.0));
        }
      }
    }
  }
}

void MarginBox::add_peak(const Case& one, const Plant& plant, double peak, bool stable, WorstMargins& out) const {
  if (peak > out.peak_sensitivity || (!stable && out.stable)) {
    out.peak_sensitivity = std::max(out.peak_sensitivity, peak);
    char text[200];
    std::snprintf(text, sizeof text, "%s, %s, %s: frequency x %.2f, damping %.2f, delay %.0f ms, pose %d ms old",
                  structures_[one.structure].name.c_str(), word(one.axis),
                  one.timing.by_sticks ? "virtual_rc" : "movement", plant.frequency, plant.damping, 1e3 * plant.delay_s,
                  10 * plant.pose_age_ticks);
    out.where = text;
  }
  out.stable = out.stable && stable;
}

const MarginBox::Law& MarginBox::law_of(const Case& one, Laws& laws) {
  std::optional<Law>& law = laws.made[(one.axis == Axis::kX ? 0U : 1U) + (one.timing.by_sticks ? 2U : 0U)];
  if (!law) {
    law.emplace(Law{.controller = FlownController(laws.believed, one.axis, one.timing), .response = {}});
    law->response = responses(one, *law->controller.lifted);
  }
  return *law;
}

bool MarginBox::is_within(Extent extent, const Case& one, const Plant& plant) {
  const bool is_certified = plant.pose_age_ticks == static_cast<int>(one.timing.pose_age_ticks);
  return (extent != Extent::kCertified || is_certified) && (extent != Extent::kNominal || plant.frequency == 1.0);
}

void MarginBox::add_case(const Case& one, const Law& law, Extent extent, WorstMargins& out) const {
  const OpenStructure& structure = structures_[one.structure];
  CaseLoop loop(law.response, law.controller.stick_gain(attitude_of(structure.vehicle, one.axis)));
  loop.open(one.corners.front().response);
  loop.set_stable();
  const bool is_box = extent == Extent::kBox || extent == Extent::kCertified;
  const Range gain = extent == Extent::kNominal ? Range{1.0, 1.0} : structure.box[one.axis == Axis::kX ? 0 : 1].gain;
  for (const Plant& plant : is_box ? one.box : one.corners) {
    if (!is_within(extent, one, plant)) {
      continue;
    }
    loop.open(plant.response);
    const bool stable = loop.is_stable(gain.low) && loop.is_stable(gain.high);
    if (is_box || plant.extra_delay_s == 0.0) {
      add_peak(one, plant, loop.peak_sensitivity(gain), stable, out);
    } else if (!stable || !loop.is_stable(1.0)) {
      out.delay_margin_s = std::min(out.delay_margin_s, plant.extra_delay_s - kDelayStep_s);
    }
  }
}

WorstMargins MarginBox::worst(Laws& laws, Extent extent, const BoxSelection& only) const {
  WorstMargins out{.delay_margin_s = kDelayStep_s * kDelaySteps};
  for (const Case& one : cases_) {
    if (only.structure.value_or(one.structure) != one.structure || only.axis.value_or(one.axis) != one.axis ||
        only.by_sticks.value_or(one.timing.by_sticks) != one.timing.by_sticks) {
      continue;
    }
    const Law& law = law_of(one, laws);
    const OpenStructure& structure = structures_[one.structure];
    if (!FlownLoop(law.controller, structure.vehicle, one.axis, one.timing).closed_is_stable()) {  // by matrix powers
      return {.stable = false, .peak_sensitivity = 1e9, .where = structure.name + ", " + word(one.axis)};
    }
    add_case(one, law, extent, out);
  }
  return out;
}

}  // namespace m100::lab::gains
