// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/excite/forecast.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "firmware/core/eigen.h"
#include "firmware/model/axis_effects.h"
#include "host_tests/lab/excite/stick_flight.h"

namespace m100::lab::excite {
namespace {

using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;

constexpr double kAirMemory_s = 0.3;

std::vector<double> respond(const Manoeuvre& manoeuvre, StickFlight flight) {
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

/// The largest response of the vehicle without any effect, and the largest rate of change of this response.
struct Largest {
  double response = 0.0;
  double rate_per_s = 0.0;
};

Largest largest(const std::vector<double>& response, double period_s) {
  Largest out;
  for (std::size_t k = 0; k < response.size(); ++k) {
    out.response = std::max(out.response, std::abs(response[k]));
    const double change = k > 0 ? std::abs(response[k] - response[k - 1]) : 0.0;
    out.rate_per_s = std::max(out.rate_per_s, change / period_s);
  }
  return out;
}

double medium_size(const model::AxisEffect& effect, const model::StickAxis& axis, const Largest& largest) {
  using Of = model::Typical::Of;
  const double size = effect.typical.size;
  return effect.typical.of == Of::kBesideOwn         ? axis.*effect.numbers[0].member + size
         : effect.typical.of == Of::kLargestResponse ? size * largest.response
         : effect.typical.of == Of::kFastestResponse ? size * largest.rate_per_s
                                                     : size;
}

}  // namespace

double other_stick(double t_s) { return 60.0 * std::sin(2.0 * std::numbers::pi * 0.23 * t_s); }

std::vector<double> response(const Manoeuvre& manoeuvre, const model::StickAxis& axis, const InputDesign& design,
                             const std::string& effect, double size) {
  model::StickAxis with = flyable(axis);
  if (!effect.empty()) {
    with.*model::axis_effect(effect)->numbers[0].member = size;
  }
  return respond(manoeuvre, StickFlight(with, design.rate));
}

/// The effects that a forecast covers, each with its medium size (model::Typical).
std::vector<std::pair<std::string, double>> medium_sizes(const Manoeuvre& manoeuvre, const model::StickAxis& axis,
                                                         const InputDesign& design, const std::vector<double>& plain) {
  const Largest without = largest(plain, manoeuvre.period_s);
  std::vector<std::pair<std::string, double>> sizes;
  for (const model::AxisEffect& effect : model::kAxisEffects) {
    if (effect.typical.size == 0.0 || (design.rate && effect.needs_other_stick)) {
      continue;
    }
    sizes.emplace_back(effect.name, medium_size(effect, axis, without));
  }
  return sizes;
}

std::vector<Forecast> forecast(const Manoeuvre& manoeuvre, const model::StickAxis& axis, const InputDesign& design) {
  const std::vector<double> plain = response(manoeuvre, axis, design, "", 0.0);
  const std::vector<std::pair<std::string, double>> sizes = medium_sizes(manoeuvre, axis, design, plain);
  // Every fit has gain, frequency, damping, delay and trim: of a signature, only what they cannot imitate counts. An
  // effect that is one of these itself is held against the others.
  Matrix fitted(static_cast<Eigen::Index>(plain.size()), 5);
  fitted.col(0) = difference(plain, std::vector<double>(plain.size(), 0.0));
  model::StickAxis faster = flyable(axis);
  faster.natural_frequency_rad_s *= 1.02;
  faster.time_constant_s /= 1.02;
  model::StickAxis stiffer = flyable(axis);
  stiffer.damping_ratio *= 1.02;
  model::StickAxis later = flyable(axis);
  later.transport_delay_s += 0.004;
  model::StickAxis tilted = flyable(axis);
  tilted.trim_counts += 1.0;
  fitted.col(1) = difference(respond(manoeuvre, StickFlight(faster, design.rate)), plain);
  fitted.col(2) = difference(respond(manoeuvre, StickFlight(stiffer, design.rate)), plain);
  fitted.col(3) = difference(respond(manoeuvre, StickFlight(tilted, design.rate)), plain);
  fitted.col(4) = difference(respond(manoeuvre, StickFlight(later, design.rate)), plain);
  const auto without = [](const Matrix& basis, const Vector& v) -> Vector {
    Matrix normal = basis.transpose() * basis;
    normal.diagonal().array() += 1e-12 * normal.trace() + 1e-300;
    return v - basis * normal.ldlt().solve(basis.transpose() * v);
  };
  std::vector<Vector> signatures;
  for (const auto& [name, size] : sizes) {
    Matrix others = fitted;
    for (const auto& [own, column] : {std::pair{"trim_offset", 3}, {"transport_delay", 4}}) {
      if (name == own) {
        others.col(column).setZero();
      }
    }
    signatures.push_back(without(others, difference(response(manoeuvre, axis, design, name, size), plain)));
  }
  // 2 memory / period correlated samples of the air count as one independent sample.
  const double spread = design.air * std::sqrt(2.0 * kAirMemory_s / manoeuvre.period_s);
  std::vector<Forecast> out;
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    Forecast one{.effect = sizes[i].first,
                 .size = sizes[i].second,
                 .sigma = signatures[i].norm() / spread,
                 .nearest = "",
                 .cosine = 0.0,
                 .apart_sigma = 0.0};
    for (std::size_t j = 0; j < sizes.size(); ++j) {
      const double norms = signatures[i].norm() * signatures[j].norm();
      const double cosine = i != j && norms > 0.0 ? std::abs(signatures[i].dot(signatures[j])) / norms : 0.0;
      if (cosine > one.cosine) {
        one.cosine = std::min(1.0, cosine);
        one.nearest = sizes[j].first;
      }
    }
    one.apart_sigma = one.sigma * std::sqrt(1.0 - one.cosine * one.cosine);
    out.push_back(one);
  }
  return out;
}

}  // namespace m100::lab::excite
