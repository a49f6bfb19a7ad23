// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/excite/manoeuvre.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "host_tests/lab/excite/pieces.h"
#include "host_tests/lab/excite/stick_flight.h"
#include "host_tests/lab/printed.h"

namespace m100::lab::excite {
namespace {

constexpr double kBetween_s = 1.0;
constexpr double kPeriod_s = 0.02;  ///< of the samples
// Margins with which a part of a piece must fit.
constexpr double kMoreAnswer = 1.2;  ///< the axis responds a fifth more than in the vehicle file
constexpr double kOffPlace_m =
    0.2;  ///< between the start and a part's begin; in flight the law comes within 0.3 m, mostly a few centimetres
constexpr double kSmaller = 0.85;     ///< factor each time that an amplitude is too large
constexpr double kMinShare = 0.3;     ///< of the requested amplitude: a smaller movement shows too little
constexpr double kMin_counts = 25.0;  ///< beyond the dead zone
constexpr int kAttempts = 30;
constexpr double kSearched_m = 20.0;

void check(const InputDesign& design) {
  const auto positive = [](double value, const char* option) {
    if (!(std::isfinite(value) && value > 0.0)) {
      throw std::invalid_argument(std::string(option) + ": must be positive");
    }
  };
  positive(design.amplitude_counts, "--amplitude");
  positive(design.duration_s, "--duration");
  positive(design.fence_m, "--fence");
  positive(design.brake_m_s2, "--brake");
  if (design.amplitude_counts > 660.0) {
    throw std::invalid_argument("--amplitude: a stick travels 660 counts");
  }
  if (design.duration_s > 3600.0) {
    throw std::invalid_argument("--duration: at most an hour");
  }
}

/// A section of a piece that is flown without interruption, from rest at the start.
struct Part {
  Piece piece;
  double from_s = 0.0;
  double to_s = 0.0;
  double amplitude_counts = 0.0;
};

/// Whether the part stays inside the fence when the axis responds more than in the vehicle file and the unforeseen
/// disturbance acts to either side all the time.
bool fits(const Part& part, const InputDesign& design, const model::StickAxis& axis) {
  StickFlight flight(flyable(axis), design.rate);
  for (double t = 0.0; t < part.to_s - part.from_s; t += kPeriod_s) {
    flight.step(std::round(part.amplitude_counts * part.piece.shape(part.from_s + t)), 0.0, kPeriod_s);
    const double pushed_s = t + kPeriod_s;
    for (const double side : {-1.0, 1.0}) {
      const double way_m = design.rate ? design.disturbance * pushed_s : 0.5 * design.disturbance * pushed_s * pushed_s;
      const double speed_m_s = design.rate ? design.disturbance : design.disturbance * pushed_s;
      if (must_abort(kMoreAnswer * flight.position_m() + side * (kOffPlace_m + way_m),
                     kMoreAnswer * flight.speed_m_s() + side * speed_m_s, design)) {
        return false;
      }
    }
  }
  return true;
}

/// Splits the piece into parts, each as long as fits at the amplitude. Empty: impossible at this amplitude.
std::vector<Part> parts_at(const Piece& piece, const InputDesign& design, const model::StickAxis& axis,
                           double amplitude) {
  std::vector<double> ends_s = piece.breaks_s;
  ends_s.push_back(piece.length_s);
  std::vector<Part> parts;
  double from_s = 0.0;
  while (from_s < piece.length_s) {
    Part part{piece, from_s, from_s, amplitude};
    for (const double end_s : ends_s) {
      const Part longer{piece, from_s, end_s, amplitude};
      part = end_s > from_s && fits(longer, design, axis) ? longer : part;
    }
    if (part.to_s <= from_s) {
      return {};
    }
    from_s = part.to_s;
    parts.push_back(part);
  }
  return parts;
}

/// The piece in as few parts as possible, at the largest amplitude at which all parts fit. Empty: there is none.
std::vector<Part> parts_of(const Piece& piece, const InputDesign& design, const model::StickAxis& axis,
                           double amplitude) {
  const double least = std::min(amplitude, std::max(kMinShare * amplitude, axis.dead_zone_counts + kMin_counts));
  for (; amplitude >= least; amplitude *= kSmaller) {
    if (std::vector<Part> parts = parts_at(piece, design, axis, amplitude); !parts.empty()) {
      return parts;
    }
  }
  return {};
}

/// The movements of the kind that fit, each as its parts; records the adaptations in `out`.
std::vector<std::vector<Part>> fitted(const InputDesign& design, const model::StickAxis& axis, double amplitude_counts,
                                      Manoeuvre& out) {
  std::vector<std::vector<Part>> all;
  for (const Piece& piece : pieces(design.kind)) {
    const std::vector<Part> parts = parts_of(piece, design, axis, amplitude_counts);
    out.left_out += parts.empty() ? 1 : 0;
    out.in_parts += parts.size() > 1 ? 1 : 0;
    if (!parts.empty()) {
      const double used = parts.front().amplitude_counts;
      out.amplitude_counts = std::max(out.amplitude_counts, used);
      out.min_amplitude_counts = std::min(out.min_amplitude_counts, used);
      all.push_back(parts);
    }
  }
  return all;
}

/// Simulates a manoeuvre on the vehicle file's axis and records it, sample by sample.
class Rehearsal {
 public:
  Rehearsal(const InputDesign& design, const model::StickAxis& axis, Manoeuvre& out)
      : wish_(design), axis_(axis), out_(out), flight_(flyable(axis), design.rate) {}

  void fly(const Part& part, double sign) {
    ++pieces_begun_;
    for (double t = part.from_s; t < part.to_s; t += out_.period_s) {
      if (must_abort(flight_.position_m(), flight_.speed_m_s(), wish_)) {
        break;
      }
      push(sign * part.amplitude_counts * part.piece.shape(t), true);
    }
  }
  /// Flies back to the start, as a pilot does.
  void home() {
    ++out_.returns;
    const double per_rad = 1.0 / axis_.scale_per_count;
    for (double t = 0.0; t < 6.0; t += out_.period_s) {
      if (std::abs(flight_.position_m()) < 0.3 && std::abs(flight_.speed_m_s()) < 0.15) {
        break;
      }
      const double tilt = -(1.0 * flight_.position_m() + 1.6 * flight_.speed_m_s()) / model::kGravity_m_s2;
      const double back = wish_.rate ? std::clamp(-0.8 * flight_.position_m(), -0.5, 0.5) : std::clamp(tilt, -0.2, 0.2);
      const double ask = back * per_rad;
      push(ask + std::copysign(std::min(std::abs(ask), 1.0) * axis_.dead_zone_counts, ask), false);
    }
  }
  void rest() {
    for (double t = 0.0; t < kBetween_s; t += out_.period_s) {
      push(0.0, false);
    }
  }

 private:
  void push(double stick, bool in_piece) {
    out_.stick_counts.push_back(std::round(stick));
    out_.piece.push_back(in_piece ? pieces_begun_ : 0);
    flight_.step(out_.stick_counts.back(), 0.0, out_.period_s);
    out_.position_m.push_back(flight_.position_m());
    out_.speed_m_s.push_back(flight_.speed_m_s());
    out_.farthest_m = std::max(out_.farthest_m, std::abs(flight_.position_m()));
    out_.fastest_m_s = std::max(out_.fastest_m_s, std::abs(flight_.speed_m_s()));
  }

  const InputDesign& wish_;
  const model::StickAxis& axis_;
  Manoeuvre& out_;
  StickFlight flight_;
  int pieces_begun_ = 0;
};

/// The pieces that fit into the fence, in sequence; after each part the pilot flies back to the start.
Manoeuvre strung(const InputDesign& design, const model::StickAxis& axis, double amplitude_counts) {
  Manoeuvre out;
  const std::vector<std::vector<Part>> all = fitted(design, axis, amplitude_counts, out);
  if (all.empty()) {
    out.farthest_m = std::numeric_limits<double>::infinity();
    return out;
  }
  Rehearsal rehearsal(design, axis, out);
  for (std::size_t n = 0; static_cast<double>(out.stick_counts.size()) * out.period_s < design.duration_s; ++n) {
    // Every second round has the opposite sign, so that both sides are excited equally.
    const double sign = (n / all.size()) % 2 == 0 ? 1.0 : -1.0;
    for (const Part& part : all[n % all.size()]) {
      rehearsal.fly(part, sign);
      rehearsal.home();
      rehearsal.rest();
    }
  }
  return out;
}

/// The next larger fence in which a manoeuvre fits, as the end of a message; empty: none up to kSearched_m larger.
std::string enough_fence(InputDesign design, const model::StickAxis& axis) {
  const double least = design.fence_m;
  for (design.fence_m = std::ceil(2.0 * least) / 2.0; design.fence_m <= least + kSearched_m; design.fence_m += 0.5) {
    if (strung(design, axis, design.amplitude_counts).farthest_m <= design.fence_m) {
      return printed("; %g is enough", design.fence_m);
    }
  }
  return "";
}

}  // namespace

const model::StickAxis& axis_of(const model::Vehicle& vehicle, const std::string& name) {
  return name == "roll"    ? vehicle.roll
         : name == "pitch" ? vehicle.pitch
         : name == "climb" ? vehicle.climb
                           : vehicle.yaw_rate;
}

bool must_abort(double position_m, double speed_m_s, const InputDesign& design) {
  const double outwards = position_m >= 0.0 ? std::max(0.0, speed_m_s) : std::max(0.0, -speed_m_s);
  return std::abs(position_m) + outwards * outwards / (2.0 * design.brake_m_s2) > design.fence_m;
}

Manoeuvre design_manoeuvre(const InputDesign& design, const model::StickAxis& axis) {
  check(design);
  double amplitude = design.amplitude_counts;
  Manoeuvre out = strung(design, axis, amplitude);
  for (int attempt = 0; attempt < kAttempts && out.farthest_m > design.fence_m; ++attempt) {
    amplitude *= kSmaller;
    out = strung(design, axis, amplitude);
  }
  if (out.farthest_m > design.fence_m) {
    throw std::invalid_argument(printed("--fence: %g is too small for any manoeuvre of this vehicle", design.fence_m) +
                                enough_fence(design, axis));
  }
  return out;
}

}  // namespace m100::lab::excite
