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
/// Room between a limit on the sampled peak over the box and the bound that certify() proves, at most 1.02 times it.
inline constexpr double kProvedOverSampled = 1.025;
/// 3.3 is the least box_peak at which a hover at 8 m/s is at most 4 % worse (decision mpc 12).
inline constexpr MarginLimits kFieldLimits{1.65, 0.15, 2.2, 0.1, 3.3 / kProvedOverSampled};
inline constexpr MarginLimits kRobustLimits{1.6, 0.15, 1.6, 0.15, 1.6 / kProvedOverSampled};

/// The worst margins of all loops over an Extent of the boxes.
struct WorstMargins {
  bool stable = true;
  double peak_sensitivity = 0.0;
  double delay_margin_s = 0.0;  ///< a multiple of 10 ms, at most 0.2 s; only for kNominal and kCorners
  std::string where{};          ///< the loop and aircraft of the largest peak, or of an unstable loop
};

/// Selects loops of a MarginBox; a member that is not given selects all.
struct BoxSelection {
  std::optional<std::size_t> structure{};
  std::optional<Axis> axis{};
  std::optional<bool> by_sticks{};
};

/// Evaluates the loop as flown of any controller on the aircraft of the boxes. The constructor computes the frequency
/// responses of the vehicles once for all controllers.
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
    kNominal,    ///< the structures themselves
    kCorners,    ///< over gain and frequency
    kCertified,  ///< over gain, frequency, damping and delay: what certify() bounds; no delay margin
    kBox,        ///< as kCertified, also with poses that arrive 20 ms earlier or later than assumed
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
    double frequency = 1.0;
    double damping = 0.0;
    double delay_s = 0.0;
    int pose_age_ticks = 2;
    double extra_delay_s = 0.0;
    Eigen::MatrixXcd response{};  ///< by input of the controller and frequency
  };
  struct Case {  ///< one structure, axis and channel
    std::size_t structure = 0;
    Axis axis = Axis::kX;
    LoopTiming timing;
    std::vector<double> frequencies_rad_s{};
    std::vector<Plant> corners{}, box{};
  };

  static Eigen::MatrixXcd responses(const Case& one, const LiftedSystem& system);
  void add_plants(Case& one);
  static bool is_within(Extent extent, const Case& one, const Plant& plant);
  static const Law& law_of(const Case& one, Laws& laws);
  /// Adds the worst margins of one case to `out`. The closed loop of the structure itself must be stable.
  void add_case(const Case& one, const Law& law, Extent extent, WorstMargins& out) const;
  void add_peak(const Case& one, const Plant& plant, double peak, bool stable, WorstMargins& out) const;
  Plant plant(const Case& one, double frequency, double damping, double delay_s, int pose_age, double extra_s) const;

  std::vector<OpenStructure> structures_;
  std::vector<Case> cases_;
};

}  // namespace m100::lab::gains
