// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/model/translation/translation_regression.h"

#include <algorithm>
#include <cmath>

namespace m100::lab::identify::translation {

using model::TranslationEffect;

bool has(const Structure& structure, std::string_view name) {
  return std::find(structure.begin(), structure.end(), name) != structure.end();
}

const std::array<Slot, kSearched>& slots() {
  static const std::array<Slot, kSearched> kSlots = [] {
    std::array<Slot, kSearched> out{};
    std::size_t at = 0;
    for (const TranslationEffect& effect : model::kTranslationEffects) {
      for (std::size_t k = 0; k < effect.searched_count(); ++k) {
        out[at++] = {&effect, k};
      }
    }
    std::stable_sort(out.begin(), out.end(),
                     [](const Slot& a, const Slot& b) { return a.parameter().turn < b.parameter().turn; });
    return out;
  }();
  return kSlots;
}

std::size_t slot_of(const TranslationEffect& effect) {
  const auto found =
      std::find_if(slots().begin(), slots().end(), [&](const Slot& slot) { return slot.effect->name == effect.name; });
  return static_cast<std::size_t>(found - slots().begin());
}

SearchPoint searched_of(const Fit& fit) {
  SearchPoint out{};
  std::copy_n(fit.parameters.begin(), kSearched, out.begin());
  return out;
}

bool is_wind_speed_searched(const Structure& structure) {
  bool wind = false;
  bool progressive = false;
  for (const TranslationEffect& effect : model::kTranslationEffects) {
    if (has(structure, effect.name)) {
      wind = wind || (effect.searched_count() > 0 && effect.searched[0].start == model::Start::kWindSpeed);
      progressive = progressive || effect.drag == model::Drag::kProgressive;
    }
  }
  return wind && progressive;
}

std::array<bool, kSearched> searched_in(const Structure& structure) {
  std::array<bool, kSearched> out{};
  const bool wind = is_wind_speed_searched(structure);
  for (std::size_t k = 0; k < kSearched; ++k) {
    const Slot& slot = slots()[k];
    out[k] = has(structure, slot.effect->name) && (wind || slot.parameter().start != model::Start::kWindSpeed);
  }
  return out;
}

std::array<double, 3> wind_of(const SearchPoint& searched) {
  std::array<double, 3> wind{};
  for (std::size_t k = 0; k < kSearched; ++k) {
    if (slots()[k].parameter().start == model::Start::kWindSpeed) {
      wind[slots()[k].which] = searched[k];
    }
  }
  return wind;
}

std::size_t linear_count(const Structure& structure, std::string_view name) {
  const TranslationEffect* effect = model::translation_effect(name);
  if (effect == nullptr || !has(structure, name)) {
    return 0;  // rigid_body
  }
  const bool speed = effect->searched_count() > 0 && effect->searched[0].start == model::Start::kWindSpeed;
  return speed && is_wind_speed_searched(structure) ? 0 : effect->columns;
}

std::size_t linear_count(const Structure& structure) {
  std::size_t count = 0;
  for (const std::string& name : structure) {
    count += linear_count(structure, name);
  }
  return count;
}

std::size_t column_of(const Structure& structure, std::string_view wanted) {
  std::size_t column = 0;
  for (const std::string& name : structure) {
    if (name == wanted) {
      break;
    }
    column += linear_count(structure, name);
  }
  return column;
}

std::span<const double> linear_of(const Fit& fit, std::string_view name) {
  return std::span(fit.parameters)
      .subspan(kSearched + column_of(fit.structure, name), linear_count(fit.structure, name));
}

Regression::Regression(const TranslationBlocks& part, const Structure& structure, const SearchPoint& searched)
    : part_(part), data_(*part.data) {
  make_moments(structure, searched);
  const auto rows = static_cast<Eigen::Index>(part.rows);
  base = Vector::Zero(rows);
  columns = Matrix::Zero(rows, static_cast<Eigen::Index>(linear_count(structure)));
  raw_.fill(std::vector<double>(moments_.size()));
  fill(base, false, [](const model::Moment& at) {
    const model::Acceleration& thrust = at.thrust_w_m_s2;
    return model::Acceleration{thrust[0], thrust[1], thrust[2] - kStandardGravity_m_s2};
  });
  Eigen::Index column = 0;
  for (const std::string& name : structure) {
    const std::size_t count = linear_count(structure, name);
    const TranslationEffect* effect = model::translation_effect(name);
    for (std::size_t k = 0; k < count; ++k) {
      const double value = effect->searched_count() > 0 ? searched[slot_of(*effect)] : 0.0;
      fill(columns.col(column++), effect->acts != model::Acts::kInThrust,
           [&](const model::Moment& at) { return effect->column(k, at, value); });
    }
  }
}

void Regression::make_moments(const Structure& structure, const SearchPoint& searched) {
  const std::size_t size = data_.valid.size();
  std::vector<double> thrust = data_.thrust;
  std::array<std::vector<double>, 3> direction = data_.direction;
  std::vector<double> spare(size);
  const model::ThrustSeries series{data_.period_s, thrust, {direction[0], direction[1], direction[2]}, spare};
  for (const TranslationEffect& effect : model::kTranslationEffects) {
    if (effect.reshape != nullptr && has(structure, effect.name)) {
      effect.reshape(series, searched[slot_of(effect)]);
    }
  }
  const std::array<double, 3> wind = wind_of(searched);
  moments_.resize(size);
  for (std::size_t i = 0; i < size; ++i) {
    model::Moment& at = moments_[i];
    at.time_s = data_.time_s(i);
    for (std::size_t c = 0; c < 3; ++c) {
      at.air_velocity_w_m_s[c] = data_.velocity[c][i] - wind[c];
      at.thrust_w_m_s2[c] = thrust[i] * direction[c][i];
      at.up_b_in_w[c] = direction[c][i];
    }
    at.heading_cosine = data_.heading_cosine[i];
    at.heading_sine = data_.heading_sine[i];
  }
}

template <typename Column, typename Law>
void Regression::fill(Column&& out, bool outer, Law&& law) {
  const bool partly = outer && data_.projection != ForceProjection::kWholeForce;
  for (std::size_t i = 0; i < moments_.size(); ++i) {
    const model::Acceleration whole = law(moments_[i]);
    const model::Acceleration u = partly ? projection(whole, moments_[i]) : whole;
    for (std::size_t c = 0; c < data_.axes; ++c) {
      raw_[c][i] = u[c];
    }
  }
  for (const TranslationBlocks::Block& block : part_.blocks) {
    std::size_t row = block.row;
    for (std::size_t c = 0; c < data_.axes; ++c) {
      for (const std::size_t i : block.samples) {
        out(static_cast<Eigen::Index>(row++)) = data_.filtered(raw_[c], i);
      }
    }
  }
}

model::Acceleration Regression::projection(const model::Acceleration& u, const model::Moment& at) const {
  constexpr double kSteepest = 0.3;
  const auto& up = at.up_b_in_w;
  const double taken = data_.projection == ForceProjection::kAcrossThrust ? u[0] * up[0] + u[1] * up[1] + u[2] * up[2]
                                                                          : u[2] / std::max(kSteepest, up[2]);
  return {u[0] - taken * up[0], u[1] - taken * up[1], u[2] - taken * up[2]};
}

}  // namespace m100::lab::identify::translation
