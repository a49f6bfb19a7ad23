// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/excite/manoeuvre.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <numbers>
#include <stdexcept>

#include "firmware/core/eigen.h"
#include "firmware/model/axis_effects.h"
#include "firmware/sysid/axis_dynamics.h"

namespace m100::lab::excite {
namespace {

using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;

constexpr double kG_m_s2 = 9.80665;
constexpr double kAirMemory_s = 0.3;
constexpr double kBetween_s = 1.0;

/// The axis with what is missing filled in, and with the stick counted from where it balances.
model::StickAxis flyable(model::StickAxis axis) {
  if (!axis.is_identified()) {
    axis.natural_frequency_rad_s = 8.7;
    axis.damping_ratio = 0.7;
  }
  axis.trim_counts = 0.0;
  return axis;
}

/// An axis answering to its stick, and the way it takes the vehicle along (or about) it.
class Flight {
 public:
  Flight(const model::StickAxis& axis, bool rate)
      : rate_(rate),
        lead_steps_(axis.lead_zero_s / kStep_s),
        law_(axis, kStep_s),
        dynamics_(axis, kStep_s),
        line_(static_cast<std::size_t>(std::lround(axis.transport_delay_s / kStep_s)) + 1, 0.0) {}

  void step(double stick_counts, double other_counts, double period_s) {
    for (double t = 0.0; t < period_s - 1e-9; t += kStep_s) {
      line_.push_back(law_.command(stick_counts, other_counts, now_s_));
      const double before = line_[0];
      line_.pop_front();
      dynamics_.step(line_[0] + lead_steps_ * (line_[0] - before));
      const double tilt_rad = std::clamp(angle(), -1.0, 1.0);
      speed_m_s_ = rate_ ? angle() : speed_m_s_ + kStep_s * kG_m_s2 * std::tan(tilt_rad);
      position_m_ += kStep_s * speed_m_s_;
      now_s_ += kStep_s;
    }
  }
  double angle() const { return dynamics_.value(); }
  double position_m() const { return position_m_; }
  double speed_m_s() const { return speed_m_s_; }

 private:
  static constexpr double kStep_s = 0.002;
  bool rate_;
  double lead_steps_;
  model::StickLaw<double> law_;
  sysid::AxisDynamics<double> dynamics_;
  std::deque<double> line_;  ///< commands on their way, the oldest first
  double position_m_ = 0.0, speed_m_s_ = 0.0, now_s_ = 0.0;
};

/// One movement: shape over its own time, between -1 and 1.
struct Piece {
  double length_s;
  std::function<double(double)> shape;  ///< of the time since its begin [s]
};

Piece doublet(double half_s) {
  return {2 * half_s, [half_s](double t) { return t < half_s ? 1.0 : -1.0; }};
}
Piece steps_3211(double unit_s) {
  return {7 * unit_s, [unit_s](double t) {
            return t < 3 * unit_s ? 1.0 : t < 5 * unit_s ? -1.0 : t < 6 * unit_s ? 1.0 : -1.0;
          }};
}
Piece chirp(double from_hz, double to_hz, double length_s) {
  return {length_s, [=](double t) {
            return std::sin(2 * std::numbers::pi * (from_hz * t + 0.5 * (to_hz - from_hz) * t * t / length_s));
          }};
}
/// Small and slow through the dead zone: what shows it, trim and play.
Piece sweep(double length_s) {
  return {length_s, [=](double t) { return 0.3 * std::sin(2 * std::numbers::pi * t / length_s); }};
}

std::vector<Piece> pieces(const std::string& kind) {
  if (kind == "doublet") {
    return {doublet(0.4), doublet(0.7), doublet(1.1)};
  }
  if (kind == "3211") {
    return {steps_3211(0.25), steps_3211(0.4)};
  }
  if (kind == "chirp") {
    return {chirp(0.3, 2.5, 8.0)};
  }
  if (kind == "mixed") {
    return {doublet(0.6), steps_3211(0.3), sweep(4.0), chirp(0.4, 2.0, 6.0), doublet(1.0), steps_3211(0.2)};
  }
  throw std::invalid_argument("--kind: doublet, 3211, chirp or mixed");
}

void check(const Wish& wish) {
  const auto positive = [](double value, const char* option) {
    if (!(std::isfinite(value) && value > 0.0)) {
      throw std::invalid_argument(std::string(option) + ": must be positive");
    }
  };
  positive(wish.amplitude_counts, "--amplitude");
  positive(wish.duration_s, "--duration");
  positive(wish.fence_m, "--fence");
  positive(wish.brake_m_s2, "--brake");
  if (wish.amplitude_counts > 660.0) {
    throw std::invalid_argument("--amplitude: a stick travels 660 counts");
  }
  if (wish.duration_s > 3600.0) {
    throw std::invalid_argument("--duration: at most an hour");
  }
}

/// Strings the pieces together at one amplitude; a pilot flies back to the middle between them.
Manoeuvre strung(const Wish& wish, const model::StickAxis& axis, double amplitude_counts) {
  Manoeuvre out;
  out.amplitude_counts = amplitude_counts;
  const std::vector<Piece> all = pieces(wish.kind);
  Flight flight(flyable(axis), wish.rate);
  int pieces_begun = 0;
  const auto push = [&](double stick, bool in_piece) {
    out.stick_counts.push_back(std::round(stick));
    out.piece.push_back(in_piece ? pieces_begun : 0);
    flight.step(out.stick_counts.back(), 0.0, out.period_s);
    out.position_m.push_back(flight.position_m());
    out.speed_m_s.push_back(flight.speed_m_s());
    out.farthest_m = std::max(out.farthest_m, std::abs(flight.position_m()));
    out.fastest_m_s = std::max(out.fastest_m_s, std::abs(flight.speed_m_s()));
  };
  const auto home = [&] {
    ++out.returns;
    const double per_rad = 1.0 / axis.scale_per_count;
    for (double t = 0.0; t < 6.0; t += out.period_s) {
      if (std::abs(flight.position_m()) < 0.3 && std::abs(flight.speed_m_s()) < 0.15) {
        break;
      }
      const double tilt = -(1.0 * flight.position_m() + 1.6 * flight.speed_m_s()) / kG_m_s2;
      const double back = wish.rate ? std::clamp(-0.8 * flight.position_m(), -0.5, 0.5) : std::clamp(tilt, -0.2, 0.2);
      const double ask = back * per_rad;
      push(ask + std::copysign(std::min(std::abs(ask), 1.0) * axis.dead_zone_counts, ask), false);
    }
  };
  for (std::size_t n = 0; static_cast<double>(out.stick_counts.size()) * out.period_s < wish.duration_s; ++n) {
    const Piece& piece = all[n % all.size()];
    // Every second round begins the other way, so that no side is learnt better than the other.
    const double sign = (n / all.size()) % 2 == 0 ? 1.0 : -1.0;
    ++pieces_begun;
    for (double t = 0.0; t < piece.length_s; t += out.period_s) {
      if (must_abort(flight.position_m(), flight.speed_m_s(), wish)) {
        break;
      }
      push(sign * amplitude_counts * piece.shape(t), true);
    }
    home();
    for (double t = 0.0; t < kBetween_s; t += out.period_s) {
      push(0.0, false);
    }
  }
  return out;
}

std::vector<double> respond(const Manoeuvre& manoeuvre, Flight flight) {
  std::vector<double> out;
  for (std::size_t k = 0; k < manoeuvre.stick_counts.size(); ++k) {
    flight.step(manoeuvre.stick_counts[k], other_stick(static_cast<double>(k) * manoeuvre.period_s),
                manoeuvre.period_s);
    out.push_back(flight.angle());
  }
  return out;
}

Vector difference(const std::vector<double>& a, const std::vector<double>& b) {
  Vector out(static_cast<Eigen::Index>(a.size()));
  for (std::size_t k = 0; k < a.size(); ++k) {
    out(static_cast<Eigen::Index>(k)) = a[k] - b[k];
  }
  return out;
}

}  // namespace

bool must_abort(double position_m, double speed_m_s, const Wish& wish) {
  const double outwards = position_m >= 0.0 ? std::max(0.0, speed_m_s) : std::max(0.0, -speed_m_s);
  return std::abs(position_m) + outwards * outwards / (2.0 * wish.brake_m_s2) > wish.fence_m;
}

Manoeuvre make(const Wish& wish, const model::StickAxis& axis) {
  check(wish);
  double amplitude = wish.amplitude_counts;
  Manoeuvre out = strung(wish, axis, amplitude);
  for (int attempt = 0; attempt < 30 && out.farthest_m > wish.fence_m; ++attempt) {
    amplitude *= 0.85;
    out = strung(wish, axis, amplitude);
  }
  if (out.farthest_m > wish.fence_m) {
    throw std::invalid_argument("--fence: too small for any manoeuvre of this vehicle");
  }
  return out;
}

double other_stick(double t_s) { return 60.0 * std::sin(2.0 * std::numbers::pi * 0.23 * t_s); }

std::vector<double> response(const Manoeuvre& manoeuvre, const model::StickAxis& axis, const Wish& wish,
                             const std::string& effect, double size) {
  model::StickAxis with = flyable(axis);
  if (!effect.empty()) {
    with.*model::axis_effect(effect)->numbers[0].member = size;
  }
  return respond(manoeuvre, Flight(with, wish.rate));
}

/// The effects that a forecast is made of, each with its size.
std::vector<std::pair<std::string, double>> medium_sizes(const Manoeuvre& manoeuvre, const model::StickAxis& axis,
                                                         const Wish& wish, const std::vector<double>& plain) {
  using Of = model::Typical::Of;
  double largest = 0.0;
  double fastest = 0.0;
  for (std::size_t k = 0; k < plain.size(); ++k) {
    largest = std::max(largest, std::abs(plain[k]));
    fastest = k > 0 ? std::max(fastest, std::abs(plain[k] - plain[k - 1]) / manoeuvre.period_s) : fastest;
  }
  std::vector<std::pair<std::string, double>> sizes;
  for (const model::AxisEffect& effect : model::kAxisEffects) {
    if (effect.typical.size == 0.0 || (wish.rate && effect.needs_other_stick)) {
      continue;
    }
    const double own = axis.*effect.numbers[0].member;
    const double size = effect.typical.size;
    sizes.emplace_back(effect.name, effect.typical.of == Of::kBesideOwn         ? own + size
                                    : effect.typical.of == Of::kLargestResponse ? size * largest
                                    : effect.typical.of == Of::kFastestResponse ? size * fastest
                                                                                : size);
  }
  return sizes;
}

std::vector<Forecast> forecast(const Manoeuvre& manoeuvre, const model::StickAxis& axis, const Wish& wish) {
  const std::vector<double> plain = response(manoeuvre, axis, wish, "", 0.0);
  const std::vector<std::pair<std::string, double>> sizes = medium_sizes(manoeuvre, axis, wish, plain);
  // Gain, frequency, damping and delay are fitted anyway; a signature counts by what they cannot imitate.
  Matrix fitted(static_cast<Eigen::Index>(plain.size()), 4);
  fitted.col(0) = difference(plain, std::vector<double>(plain.size(), 0.0));
  model::StickAxis faster = flyable(axis);
  faster.natural_frequency_rad_s *= 1.02;
  faster.time_constant_s /= 1.02;
  model::StickAxis stiffer = flyable(axis);
  stiffer.damping_ratio *= 1.02;
  model::StickAxis later = flyable(axis);
  later.transport_delay_s += 0.004;
  fitted.col(1) = difference(respond(manoeuvre, Flight(faster, wish.rate)), plain);
  fitted.col(2) = difference(respond(manoeuvre, Flight(stiffer, wish.rate)), plain);
  fitted.col(3) = difference(respond(manoeuvre, Flight(later, wish.rate)), plain);
  const auto without = [](const Matrix& basis, const Vector& v) -> Vector {
    Matrix normal = basis.transpose() * basis;
    normal.diagonal().array() += 1e-12 * normal.trace() + 1e-300;
    return v - basis * normal.ldlt().solve(basis.transpose() * v);
  };
  std::vector<Vector> signatures;
  for (const auto& [name, size] : sizes) {
    const bool delay = name == "transport_delay";
    const Vector raw = difference(response(manoeuvre, axis, wish, name, size), plain);
    signatures.push_back(without(delay ? Matrix(fitted.leftCols(3)) : fitted, raw));
  }
  // 2 memory / period samples of the air are worth one.
  const double spread = wish.air * std::sqrt(2.0 * kAirMemory_s / manoeuvre.period_s);
  std::vector<Forecast> out;
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    Forecast one{.effect = sizes[i].first,
                 .size = sizes[i].second,
                 .sigma = signatures[i].norm() / spread,
                 .nearest = "",
                 .likeness = 0.0,
                 .apart_sigma = 0.0};
    for (std::size_t j = 0; j < sizes.size(); ++j) {
      const double norms = signatures[i].norm() * signatures[j].norm();
      const double likeness = i != j && norms > 0.0 ? std::abs(signatures[i].dot(signatures[j])) / norms : 0.0;
      if (likeness > one.likeness) {
        one.likeness = std::min(1.0, likeness);
        one.nearest = sizes[j].first;
      }
    }
    one.apart_sigma = one.sigma * std::sqrt(1.0 - one.likeness * one.likeness);
    out.push_back(one);
  }
  return out;
}

}  // namespace m100::lab::excite
