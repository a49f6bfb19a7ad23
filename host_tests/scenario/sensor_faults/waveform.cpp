// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/scenario/sensor_faults/waveform.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>
#include <stdexcept>

namespace m100::scenario {
namespace {

constexpr double kRemembered_s = 2.0;
constexpr double kShortestPeriod_s = 0.1;
constexpr std::size_t kMaxPieces = 3;
constexpr double kToTheEnd_s = 30.0;  // longer than the watched time of a flight

/// Weight of a piece: 0 before it begins, 1 after it has faded in.
double share_of(const Piece& piece, double t_s) {
  return piece.fade_s <= 0.0 ? 1.0 : std::min(1.0, (t_s - piece.from_s) / piece.fade_s);
}

/// Draws logarithmically uniform between two positive numbers.
double between(double low, double high, sim::Random& random) { return low * std::pow(high / low, random.uniform()); }

double drawn_size(WaveformShape shape, const Sizes& sizes, sim::Random& random) {
  switch (shape) {
    case WaveformShape::kDelay:
      return between(0.02, 1.5, random);  // seconds
    case WaveformShape::kGain:
      return -2.0 + 5.0 * random.uniform();  // factor -1 to 4
    default:
      return between(sizes.min, sizes.max, random);
  }
}

Value drawn_direction(const Sizes& sizes, sim::Random& random) {
  Value direction = Value::Zero();
  for (Eigen::Index i = 0; i < sizes.width; ++i) {
    direction[i] = random.normal();
  }
  return direction.norm() > 0.0 ? Value(direction.normalized()) : Value(Value::UnitX());
}

Piece drawn_piece(const Sizes& sizes, double earliest_s, double within_s, sim::Random& random) {
  Piece piece;
  piece.shape = static_cast<WaveformShape>(random.next() % kShapeNames.size());
  piece.from_s = earliest_s + (within_s - earliest_s) * random.uniform();
  piece.for_s = random.uniform() < 0.5 ? kToTheEnd_s : between(0.1, kToTheEnd_s, random);
  piece.fade_s = random.uniform() < 0.3 ? 0.0 : between(kShortestPeriod_s, 10.0, random);
  piece.size = drawn_size(piece.shape, sizes, random);
  piece.direction = drawn_direction(sizes, random);
  return piece;
}

/// Changes one member of the piece slightly.
void nudge(Piece& piece, const Sizes& sizes, double earliest_s, double within_s, sim::Random& random) {
  switch (random.next() % 5) {
    case 0:
      piece.from_s = std::clamp(piece.from_s + random.normal(), earliest_s, within_s);
      break;
    case 1:
      piece.for_s = std::clamp(piece.for_s * std::exp(0.5 * random.normal()), 0.05, kToTheEnd_s);
      break;
    case 2:
      piece.fade_s = std::clamp(piece.fade_s * std::exp(0.5 * random.normal()) + 0.05 * random.uniform(), 0.0, 10.0);
      break;
    case 3:
      piece.size = piece.shape == WaveformShape::kGain ? std::clamp(piece.size + 0.5 * random.normal(), -2.0, 3.0)
                                                       : piece.size * std::exp(0.4 * random.normal());
      piece.size = std::min(piece.size, std::max(sizes.max, 3.0));
      break;
    default:
      piece.direction = (piece.direction + 0.4 * drawn_direction(sizes, random)).normalized();
      break;
  }
}

}  // namespace

std::string to_text(const Waveform& wave) {
  std::ostringstream out;
  out.precision(4);
  for (std::size_t i = 0; i < wave.size(); ++i) {
    const Piece& p = wave[i];
    out << (i > 0 ? "; " : "") << kShapeNames[static_cast<std::size_t>(p.shape)] << " " << p.from_s << " " << p.for_s
        << " " << p.fade_s << " " << p.size << " " << p.direction.x() << " " << p.direction.y() << " "
        << p.direction.z();
  }
  return out.str();
}

Waveform waveform_of(const std::string& text) {
  Waveform wave;
  std::istringstream pieces(text);
  for (std::string one; std::getline(pieces, one, ';');) {
    std::istringstream words(one);
    std::string word;
    Piece p;
    words >> word >> p.from_s >> p.for_s >> p.fade_s >> p.size >> p.direction.x() >> p.direction.y() >> p.direction.z();
    const auto* const found = std::find(kShapeNames.begin(), kShapeNames.end(), word);
    if (words.fail() || found == kShapeNames.end()) {
      throw std::invalid_argument("malformed piece of a waveform: " + one);
    }
    p.shape = static_cast<WaveformShape>(found - kShapeNames.begin());
    wave.push_back(p);
  }
  return wave;
}

WaveformInjector::WaveformInjector(Waveform wave, std::uint64_t seed)
    : wave_(std::move(wave)), anchors_(wave_.size()), noise_(seed, "teller") {}

Value WaveformInjector::delayed_value(double t_s) const {
  for (auto heard = truths_.rbegin(); heard != truths_.rend(); ++heard) {
    if (heard->t_s <= t_s) {
      return heard->truth;
    }
  }
  return truths_.front().truth;
}

Value WaveformInjector::changed(std::size_t index, double t_s, const Value& value, const Value& truth) {
  const Piece& piece = wave_[index];
  const Value& anchor = *anchors_[index];
  const double share = share_of(piece, t_s);
  switch (piece.shape) {
    case WaveformShape::kBias:
      return value + share * piece.size * piece.direction;
    case WaveformShape::kDrift: {
      const double ran_s = std::min(t_s - piece.from_s, piece.for_s);
      return value + share * piece.size * ran_s * piece.direction;
    }
    case WaveformShape::kSwing: {
      const double period_s = std::max(piece.fade_s, kShortestPeriod_s);
      return value + piece.size * std::sin(2.0 * std::numbers::pi * (t_s - piece.from_s) / period_s) * piece.direction;
    }
    case WaveformShape::kDelay:
      return value + delayed_value(t_s - share * piece.size) - truth;
    case WaveformShape::kGain:
      return value + share * piece.size * (truth - anchor);
    case WaveformShape::kNoise:
      return value + share * piece.size * noise_.normal() * piece.direction;
    case WaveformShape::kSign:
      return value - 2.0 * share * piece.direction.dot(truth - anchor) * piece.direction;
    case WaveformShape::kDropout:
      break;
  }
  return value;
}

std::optional<Value> WaveformInjector::apply(double t_s, const Value& truth, bool anchored) {
  truths_.push_back({t_s, truth});
  while (truths_.front().t_s < t_s - kRemembered_s) {
    truths_.pop_front();
  }
  Value value = truth;
  bool drops = false;
  for (std::size_t i = 0; i < wave_.size(); ++i) {
    const Piece& piece = wave_[i];
    const bool keeps = piece.shape == WaveformShape::kDrift;
    if (t_s < piece.from_s || (!keeps && t_s > piece.from_s + piece.for_s)) {
      continue;
    }
    if (!anchors_[i]) {
      anchors_[i] = anchored ? truth : Value(Value::Zero());
    }
    drops = drops || piece.shape == WaveformShape::kDropout;
    value = changed(i, t_s, value, truth);
  }
  return drops ? std::nullopt : std::optional(value);
}

Waveform drawn_wave(const Sizes& sizes, double earliest_s, double within_s, sim::Random& random) {
  Waveform wave;
  for (std::size_t count = 1 + random.next() % kMaxPieces; count > 0; --count) {
    wave.push_back(drawn_piece(sizes, earliest_s, within_s, random));
  }
  return wave;
}

Waveform neighbour_of(const Waveform& wave, const Sizes& sizes, double earliest_s, double within_s,
                      sim::Random& random) {
  Waveform next = wave;
  Piece& piece = next[random.next() % next.size()];
  const double dice = random.uniform();
  if (dice < 0.1 && next.size() < kMaxPieces) {
    next.push_back(drawn_piece(sizes, earliest_s, within_s, random));
  } else if (dice < 0.2 && next.size() > 1) {
    piece = next.back();
    next.pop_back();
  } else if (dice < 0.25) {
    piece = drawn_piece(sizes, earliest_s, within_s, random);
  } else {
    for (std::uint64_t changes = 1 + random.next() % 2; changes > 0; --changes) {
      nudge(piece, sizes, earliest_s, within_s, random);
    }
  }
  return next;
}

}  // namespace m100::scenario
