// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "firmware/companion/files/vehicle_file.h"
#include "host_tests/lab/gains/flown_loop.h"
#include "host_tests/lab/gains/margins.h"

namespace m100::lab::gains {

struct Range {
  double low = 0.0;
  double high = 0.0;
};

/// The range of aircraft around one structure of one axis: factors on gain and frequency, damping ratio, transport
/// delay. At least +-20 %, +-0.1 and +-10 ms; more where the identification's interval is wider.
struct AxisBox {
  Range gain{0.8, 1.2};
  Range frequency{0.8, 1.2};
  Range damping{};  ///< the ratio itself, never below 0
  Range delay_s{};  ///< the delay itself, never below 0
};
AxisBox axis_box(const model::StickAxis& axis, const companion::Intervals& intervals);

/// A vehicle model that the identification does not exclude, with the box of parameters around it.
struct OpenStructure {
  std::string name;
  model::Vehicle vehicle;
  std::array<AxisBox, 2> box;  ///< by Axis
};

/// The identified axes, then for k = 1, 2, ... the k-th rivals of roll and pitch. An axis without a k-th rival stays as
/// identified.
std::vector<OpenStructure> open_structures(const companion::VehicleFile& file);

/// The limits that a mode keeps in the loop as flown: on the structures themselves (nominal), over kCorners and over
/// kBox. Without a value there is no limit.
struct MarginLimits {
  double nominal_peak = 1e3;
  double nominal_delay_s = 0.0;
  double corner_peak = 1e3;
  double corner_delay_s = 0.0;
  double box_peak = 1e3;
};
/// 3.3 is the least box_peak at which a hover at 8 m/s is at most 4 % worse (decision mpc 12). The peak is sampled, so
/// the true one may be 2 % larger.
inline constexpr MarginLimits kFieldLimits{1.65, 0.15, 2.2, 0.1, 3.3};
inline constexpr MarginLimits kRobustLimits{1.6, 0.15, 1.6, 0.15, 1.6};

/// One aircraft of a box, in one loop.
struct BoxPoint {
  std::string structure{};
  Axis axis = Axis::kX;
  LoopTiming timing{};     ///< as it really is: the pose may be older or younger than the observer assumes
  double frequency = 1.0;  ///< factor
  double damping = 0.0;
  double delay_s = 0.0;   ///< without timing.extra_delay_s
  double gain = 1.0;      ///< factor
  double at_rad_s = 0.0;  ///< of the largest sensitivity; 0: a point of the delay margin
  std::string text() const;
};

/// The worst margins of all loops over an Extent of the boxes.
struct WorstMargins {
  bool stable = true;
  double peak_sensitivity = 0.0;
  double delay_margin_s = 0.0;  ///< a multiple of 10 ms, at most 0.2 s; not for kBoxPeak
  BoxPoint at_peak{};           ///< or of an unstable loop
  BoxPoint at_delay{};          ///< the delay margin plus 10 ms makes it unstable
  std::size_t points = 0;       ///< aircraft and frequencies at which the sensitivity was evaluated
  std::string peak_text() const;
  std::string delay_text() const;
};

/// Selects loops of a MarginBox; a member that is not given selects all.
struct BoxSelection {
  std::optional<std::size_t> structure{};
  std::optional<Axis> axis{};
  std::optional<bool> by_sticks{};
};

/// Evaluates the loop as flown of any controller on the aircraft of the boxes. A box is sampled on a grid: frequency as
/// identified and at both ends, damping and delay likewise, poses that arrive at once, as assumed and twice as late,
/// 200 steps in frequency; the worst gain at each point follows in closed form. A coordinate search then refines the
/// worst aircraft. The constructor computes the frequency responses of the grid's aircraft once for all controllers.
class MarginBox {
  struct Law {
    FlownController controller;
    Eigen::MatrixXcd response;  ///< by input and frequency
  };

 public:
  /// @param points steps in frequency from 0.3 rad/s; the default finds a peak within a hundredth. Throws
  ///   std::domain_error for an axis of first order.
  explicit MarginBox(std::vector<OpenStructure> structures, int points = 200);

  enum class Extent {
    kNominal,  ///< the structures themselves
    kCorners,  ///< over gain and frequency
    kBoxPeak,  ///< over gain, frequency, damping, delay, and poses that arrive 20 ms earlier or later than assumed
    kBox,      ///< as kBoxPeak, also its delay margin
  };
  /// The laws of one design, each made when it is first needed: the same on all structures and over every extent.
  struct Laws {
    model::Vehicle believed;
    std::array<std::optional<Law>, 4> made{};  ///< by axis and channel
  };
  WorstMargins worst(Laws& laws, Extent extent, const BoxSelection& only = {}) const;
  WorstMargins worst(const model::Vehicle& believed, Extent extent, const BoxSelection& only = {}) const {
    Laws laws{believed};
    return worst(laws, extent, only);
  }
  const std::vector<OpenStructure>& structures() const { return structures_; }

 private:
  struct Plant {
    BoxPoint of;
    Eigen::MatrixXcd response{};  ///< by input of the controller and frequency
  };
  struct Case {  ///< one structure, axis and channel
    std::size_t structure = 0;
    Axis axis = Axis::kX;
    LoopTiming timing;
    std::vector<double> frequencies_rad_s{};
    std::vector<Plant> corners{}, box{};
  };

  class CaseLoop;  ///< of one law with the plants of a case
  CaseLoop loop_of(const Case& one, const Law& law) const;
  static Eigen::MatrixXcd responses(const Case& one, const LiftedSystem& system);
  static const Law& law_of(const Case& one, Laws& laws);
  const AxisBox& box_of(const Case& one) const { return structures_[one.structure].box[one.axis == Axis::kX ? 0 : 1]; }
  model::Vehicle vehicle_at(const Case& one, const BoxPoint& point) const;
  Eigen::MatrixXcd responses(const Case& one, const BoxPoint& point) const;
  void add_plants(Case& one);
  /// Adds the worst margins of one case to `out`. The closed loop of the structure itself must be stable.
  void add_case(const Case& one, const Law& law, Extent extent, WorstMargins& out) const;
  void add_box_delay(const Case& one, const Law& law, WorstMargins& out) const;
  void refine(const Case& one, const Law& law, WorstMargins& out) const;

  std::vector<OpenStructure> structures_;
  std::vector<Case> cases_;
};

}  // namespace m100::lab::gains
