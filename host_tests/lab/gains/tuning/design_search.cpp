// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/gains/tuning/design_search.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <stdexcept>

#include "firmware/safety/limits.h"
#include "host_tests/lab/on_all_cores.h"

namespace m100::lab::gains {
namespace {

/// Factors on the numbers of the vehicle file, in the order of apply().
constexpr std::size_t kWeights = 9;
constexpr std::size_t kFactors = 13;
using Factors = std::array<double, kFactors>;

/// Starts: the present law, and for each mode one that a search found for the shipped vehicle. They shorten the search.
constexpr std::array<Factors, 3> kStarts{{
    {1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0},
    {0.03904, 0.4469, 2.724, 0.2102, 3.284, 1.87, 2.855, 2.097, 3.312, 1.088, 0.8924, 1.1, 0.8716},
    {0.03039, 0.1288, 62.8, 15.21, 13.49, 3.339, 0.1376, 0.1836, 0.8171, 1.122, 0.9417, 0.8149, 0.5524},
}};
constexpr int kTrials = 60;  ///< of each search

model::StickAxis scaled(model::StickAxis axis, const Factors& f) {
  axis.natural_frequency_rad_s *= f[9];
  axis.damping_ratio *= f[10];
  axis.transport_delay_s *= f[11];
  axis.lead_zero_s *= f[12];
  return axis;
}

/// The law of `law` as a design of `vehicle`. Its axes differ from those of the vehicle in their dynamics only.
model::Design design_of(const model::Vehicle& law, const model::Vehicle& vehicle) {
  model::Design out;
  out.mpc = law.mpc;
  out.estimator = law.estimator;
  out.has_mpc = out.has_estimator = true;
  model::StickAxis roll = vehicle.roll, pitch = vehicle.pitch;
  bool differs = false;
  for (const auto number :
       {&model::StickAxis::time_constant_s, &model::StickAxis::natural_frequency_rad_s,
        &model::StickAxis::damping_ratio, &model::StickAxis::transport_delay_s, &model::StickAxis::lead_zero_s}) {
    differs = differs || roll.*number != law.roll.*number || pitch.*number != law.pitch.*number;
    roll.*number = law.roll.*number;
    pitch.*number = law.pitch.*number;
  }
  if (differs) {
    out.roll = roll;
    out.pitch = pitch;
  }
  return out;
}

/// `law` with its numbers times the factors.
model::Vehicle scaled(model::Vehicle law, const Factors& f) {
  // The search determines no more than three digits.
  const auto rounded = [](double value) {
    const double unit = std::pow(10.0, std::floor(std::log10(value)) - 2.0);
    return std::stod(std::to_string(std::round(value / unit)) + "e" +
                     std::to_string(int(std::round(std::log10(unit)))));
  };
  auto& w = law.mpc;
  auto& e = law.estimator;
  const std::array numbers{&w.velocity,
                           &w.tilt,
                           &w.input,
                           &w.input_rate,
                           &e.tilt_rate_process_rad_s,
                           &e.disturbance_process_m_s2,
                           &e.input_offset_process_rad,
                           &e.attitude_sigma_rad,
                           &e.rate_sigma_rad_s};
  for (std::size_t k = 0; k < kWeights; ++k) {
    *numbers[k] = *numbers[k] > 0.0 ? rounded(*numbers[k] * f[k]) : *numbers[k];
  }
  law.roll = scaled(law.roll, f);
  law.pitch = scaled(law.pitch, f);
  return law;
}

double over(double value, double limit) { return std::max(0.0, value / limit - 1.0); }
double under(double value, double limit) { return limit > 0.0 ? std::max(0.0, 1.0 - value / limit) : 0.0; }

class Search {
 public:
  /// @param before the flown errors that a trial's are shares of
  /// @param tried called once a trial
  Search(const model::Vehicle& vehicle, const MarginBox& box, const FlyDesign& fly, const FlownScore& before,
         const std::function<void()>& tried)
      : vehicle_(vehicle), box_(box), fly_(fly), before_(before), tried_(tried) {}

  /// @param law whose numbers the factors multiply
  /// @param changes how many of the factors may change, from the first
  DesignTrial run(const model::Vehicle& law, const Factors& start, const MarginLimits& limits, const FlownLimits& flown,
                  std::size_t changes) {
    law_ = law;
    limits_ = &limits;
    flown_limits_ = flown;
    best_ = {};
    best_.excess = std::numeric_limits<double>::infinity();
    found_ = start;
    left_ = kTrials;
    best_ = trial(found_);
    for (double step = 1.6; step > 1.06 && left_ > 0;) {
      bool better = false;
      for (std::size_t k = 0; k < changes && left_ > 0; ++k) {
        better = improve(k, step) || better;
      }
      step = better ? step : std::sqrt(step);
    }
    for (; left_ > 0; --left_) {
      tried_();
    }
    return best_;
  }
  const Factors& found() const { return found_; }
  const std::vector<DesignTrial>& flown() const { return trials_; }

  /// A law as it is, flown even if it breaks the limits.
  DesignTrial as_it_is(const model::Vehicle& law, const MarginLimits& limits, const FlownLimits& flown) {
    limits_ = &limits;
    flown_limits_ = flown;
    best_.excess = std::numeric_limits<double>::infinity();
    return trial(design_of(law, vehicle_));
  }

 private:
  /// Tries one factor larger, then smaller. @returns whether one of them is better, and now the best
  bool improve(std::size_t k, double step) {
    const double size = k < kWeights ? step : 1.0 + 0.25 * (step - 1.0);  // the model's numbers are known better
    for (const double factor : {size, 1.0 / size}) {
      Factors next = found_;
      next[k] *= factor;
      const DesignTrial one = trial(next);
      if (is_better(one)) {
        best_ = one;
        found_ = next;
        return true;
      }
    }
    return false;
  }

  bool is_better(const DesignTrial& one) const {
    return one.excess > 0.0 || best_.excess > 0.0 ? one.excess < best_.excess * (1.0 - 1e-9)
                                                  : one.error < best_.error * (1.0 - 1e-4);
  }

  DesignTrial trial(const Factors& factors) {
    tried_();
    --left_;
    return trial(design_of(scaled(law_, factors), vehicle_));
  }

  DesignTrial trial(const model::Design& design) {
    DesignTrial out;
    out.design = design;
    model::Vehicle believed = vehicle_;
    believed.design = design;
    MarginBox::Laws laws{believed};
    companion::VehicleFile file;
    try {
      file = companion::as_file(believed);
      out.corners = box_.worst(laws, MarginBox::Extent::kCorners);
      out.nominal = box_.worst(laws, MarginBox::Extent::kNominal);
    } catch (const std::exception&) {  // not allowed in a vehicle file, or no controller can be made from this model
      out.excess = std::numeric_limits<double>::infinity();
      return out;
    }
    // What already exceeds the limits by more than the best does needs no box and no flights.
    const auto is_excluded = [&] {
      out.excess = margin_excess(out, *limits_);
      return out.excess > 0.0 && out.excess >= best_.excess;
    };
    if (is_excluded()) {
      return out;
    }
    out.box = box_.worst(laws, MarginBox::Extent::kBoxPeak);
    if (is_excluded()) {
      return out;
    }
    const auto [flown, is_new] = flown_.try_emplace(file.digest);
    if (is_new) {
      flown->second = fly_(believed);
    }
    out.flown = flown->second;
    out.was_flown = true;
    out.error = 0.2 * (out.flown.hover_m / before_.hover_m + out.flown.wind_m / before_.wind_m +
                       out.flown.square_m / before_.square_m + out.flown.step_m_s / before_.step_m_s +
                       out.flown.settled_s / before_.settled_s);
    out.excess += flown_limits_.excess(out.flown);
    trials_.push_back(out);
    return out;
  }

  const model::Vehicle& vehicle_;
  const MarginBox& box_;
  const FlyDesign& fly_;
  const FlownScore& before_;
  const std::function<void()>& tried_;
  std::vector<DesignTrial> trials_;  ///< that were flown
  model::Vehicle law_;               ///< whose numbers the factors multiply
  const MarginLimits* limits_ = nullptr;
  FlownLimits flown_limits_;
  std::map<core::Sha256Digest, FlownScore> flown_;  ///< by the digest of the vehicle file: a search comes back
  int left_ = 0;                                    ///< trials
  DesignTrial best_;
  Factors found_{};  ///< of the best
};

}  // namespace

double margin_excess(const DesignTrial& trial, const MarginLimits& limits) {
  return (trial.corners.stable && trial.box.stable ? 0.0 : 100.0) + (trial.nominal.stable ? 0.0 : 1000.0) +
         over(std::min(trial.corners.peak_sensitivity, 1e3), limits.corner_peak) +
         under(trial.corners.delay_margin_s, limits.corner_delay_s) +
         over(std::min(trial.box.peak_sensitivity, 1e3), limits.box_peak) +
         over(std::min(trial.nominal.peak_sensitivity, 1e3), limits.nominal_peak) +
         under(trial.nominal.delay_margin_s, limits.nominal_delay_s);
}

double FlownLimits::excess(const FlownScore& flown) const {
  return over(flown.motion_deg_s, kMaxMotion_deg_s) + over(flown.tilt_deg, tilt_deg) + over(flown.hover_m, hover_m) +
         over(flown.wind_m, wind_m) + over(flown.square_m, square_m) + over(flown.step_m_s, step_m_s) +
         (flown.stayed ? 0.0 : 10.0);
}

FlownLimits field_limits(const model::Vehicle& vehicle, const FlownScore& before) {
  constexpr double kDegrees = 57.29577951;
  const double count_deg = std::max(vehicle.roll.scale_per_count, vehicle.pitch.scale_per_count) * kDegrees;
  return {.tilt_deg = std::max(before.tilt_deg + count_deg, safety::Envelope{}.tilt_rad * kDegrees),
          .hover_m = kMaxHoverPrice * before.hover_m,
          .wind_m = kMaxWindPrice * before.wind_m};
}

DesignSearchResult search_designs(const model::Vehicle& vehicle, const model::Vehicle& present, const MarginBox& box,
                                  const FlyDesign& fly,
                                  const std::function<void(double share, const std::string& what)>& progress) {
  DesignSearchResult result;
  model::Vehicle plain = vehicle;
  plain.design = plain.robust = {};
  result.before = fly(plain);
  constexpr int kSearches = 4;
  std::atomic<int> count = 0;
  const auto told = [&](const char* what) {
    return [&count, &progress, what] { progress(double(++count) / (kSearches * kTrials), what); };
  };
  const auto pick = [](ModeDesign& into, const DesignTrial& one, double factor) {
    const bool first = !into.best.was_flown && into.best.excess == 0.0;
    const bool better = one.excess > 0.0 || into.best.excess > 0.0 ? one.excess < into.best.excess
                                                                   : one.error < factor * into.best.error;
    into.best = first || better ? one : into.best;
    into.kept = into.best.excess == 0.0 && into.best.was_flown;
  };
  const std::function<void()> field_tried = told("mode field"), robust_tried = told("mode robust");
  Search for_field(plain, box, fly, result.before, field_tried);
  Search for_robust(plain, box, fly, result.before, robust_tried);
  const auto search_field = [&] {
    FlownLimits field = field_limits(vehicle, result.before);
    const model::Vehicle law = model::controller_model(present);
    // A correction of the model may spend the room that a nominal delay margin leaves, down to that of the corners.
    MarginLimits ordered = kFieldLimits;
    ordered.nominal_delay_s = ordered.corner_delay_s;
    pick(result.field, for_field.as_it_is(law, ordered, {.tilt_deg = field.tilt_deg}), 1.0);
    result.present = result.field;
    if (result.present.kept) {
      const FlownScore& flown = result.present.best.flown;
      field = {field.tilt_deg, flown.hover_m, flown.wind_m, flown.square_m, flown.step_m_s};
    }
    pick(result.field, for_field.run(law, kStarts[0], kFieldLimits, field, kWeights), 1.0);
    pick(result.field, for_field.run(plain, kStarts[1], kFieldLimits, field, kFactors), 0.99);
  };
  const auto search_robust = [&] {
    if (present.robust.exists()) {
      model::Vehicle robust = present;
      robust.design = present.robust;
      pick(result.robust, for_robust.as_it_is(model::controller_model(robust), kRobustLimits, {}), 1.0);
    }
    pick(result.robust, for_robust.run(plain, kStarts[2], kRobustLimits, {}, kFactors), 1.0);
    pick(result.robust, for_robust.run(plain, for_robust.found(), kRobustLimits, {}, kFactors), 1.0);
  };
  // Neither search needs what the other finds.
  on_all_cores(2, [&](std::size_t i) { i == 0 ? search_field() : search_robust(); });
  result.trials = for_field.flown();
  result.trials.insert(result.trials.end(), for_robust.flown().begin(), for_robust.flown().end());
  if (!result.field.best.corners.stable) {
    throw std::domain_error("no design is stable in every corner of what the identification leaves open; the worst: " +
                            result.field.best.corners.at_peak.text());
  }
  return result;
}

std::optional<DesignTrial> least_error(const std::vector<DesignTrial>& trials, const MarginLimits& limits) {
  std::optional<DesignTrial> out;
  for (const DesignTrial& one : trials) {
    const bool flies = one.corners.stable && one.flown.stayed && one.flown.motion_deg_s <= kMaxMotion_deg_s;
    if (flies && margin_excess(one, limits) == 0.0 && (!out || one.error < out->error)) {
      out = one;
    }
  }
  return out;
}

}  // namespace m100::lab::gains
