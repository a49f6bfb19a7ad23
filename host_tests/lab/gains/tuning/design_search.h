// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "host_tests/lab/gains/margin_box.h"

namespace m100::lab::gains {

/// The errors of the reference tasks, as flown in simulation with one design.
struct FlownScore {
  double hover_m = 0.0;    ///< horizontal RMS of a hover in calm air
  double wind_m = 0.0;     ///< horizontal RMS of a hover in a wind of 8 m/s with gusts
  double square_m = 0.0;   ///< horizontal RMS on the square of 1 m
  double step_m_s = 0.0;   ///< integral of the horizontal error of a step of 6 m [m s]
  double settled_s = 0.0;  ///< from the start of that step until the error stays below 2 cm
  double motion_deg_s = 0.0;
  double tilt_deg = 0.0;  ///< worst tilt of the step
  bool stayed = false;
};
using FlyDesign = std::function<FlownScore(const model::Vehicle& believed)>;

/// One design that was tried.
struct DesignTrial {
  model::Design design;
  WorstMargins nominal, corners, box;  ///< the box only if the others do not exclude the trial
  FlownScore flown;
  bool was_flown = false;  ///< false: the margins alone excluded it
  double error = 0.0;      ///< mean of the five errors, each as a share of that of the vehicle file
  double excess = 0.0;     ///< sum of the shares by which limits are exceeded; 0: all are kept
};

/// A design for one mode.
struct ModeDesign {
  DesignTrial best;
  bool kept = false;  ///< false: no trial keeps the limits; `best` exceeds them least
};

struct DesignSearchResult {
  ModeDesign field, robust;
  ModeDesign present;  ///< the law that flies now, on the corrected model; kept: in all limits of mode field
  FlownScore before;   ///< the vehicle file without its designs
  std::vector<DesignTrial> trials;  ///< all that were flown
};

inline constexpr double kMaxMotion_deg_s = 40.0;
// Mode field: largest errors in hover and in wind, relative to those of the file.
inline constexpr double kMaxHoverPrice = 1.66, kMaxWindPrice = 1.04;

/// Sum of the shares by which a design exceeds the limits, at least 100 if it is unstable somewhere.
double margin_excess(const DesignTrial& trial, const MarginLimits& limits);

/// The limits of a mode on the simulated flights.
struct FlownLimits {
  double tilt_deg = 90.0;                                    ///< worst of the step
  double hover_m = std::numeric_limits<double>::infinity();  ///< horizontal error
  double wind_m = std::numeric_limits<double>::infinity();   ///< the same in wind
  double square_m = std::numeric_limits<double>::infinity();
  double step_m_s = std::numeric_limits<double>::infinity();
  /// Sum of the shares by which these limits and kMaxMotion_deg_s are exceeded; at least 10 if a flight did not stay.
  double excess(const FlownScore& flown) const;
};
/// The limits of mode field, from the flights `before` of the file without its designs. The error in hover may be
/// kMaxHoverPrice times that of `before`, in wind kMaxWindPrice times. The tilt may be the supervisor's limit, or that
/// of `before` plus one stick count if that is larger.
FlownLimits field_limits(const model::Vehicle& vehicle, const FlownScore& before);

/// Chooses weights, noises and the controller's model for the modes field and robust. The mean error of the reference
/// tasks is to be least, while the limits of the mode on the margins and on the simulated flights are kept. The margins
/// are those of all structures and both channels. Where the law that flies now keeps them, too (its nominal
/// delay margin may be down to that of the corners), the design of mode field is no worse than it in hover, wind,
/// square and step. It is a pattern search with a fixed number of trials. Throws std::domain_error if no design for
/// mode field is stable in every corner.
/// @param present vehicle file of the law that flies now
/// @param fly called from two threads at once, as is `progress`
/// @param progress receives the share of the work that is done, and what is searched
DesignSearchResult search_designs(const model::Vehicle& vehicle, const model::Vehicle& present, const MarginBox& box,
                                  const FlyDesign& fly,
                                  const std::function<void(double share, const std::string& what)>& progress);

/// The trial of least error that keeps the limits and kMaxMotion_deg_s, and stayed, if there is one.
std::optional<DesignTrial> least_error(const std::vector<DesignTrial>& trials, const MarginLimits& limits);

}  // namespace m100::lab::gains
