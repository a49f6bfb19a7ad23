// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/model/translation/translation_regression.h"

#include <algorithm>
#include <functional>
#include <string>

namespace m100::lab::identify::translation {

using model::TranslationEffect;

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

std::size_t ColumnCache::Hash::operator()(const Key& key) const {
  std::size_t out = mixed(std::hash<std::string_view>{}(key.effect), key.which + 16U * key.reshaped_by);
  out = mixed(out, std::hash<double>{}(key.value));
  for (const double value : key.reshapes) {
    out = mixed(out, std::hash<double>{}(value));
  }
  return out;
}

const Vector* ColumnCache::find(const Key& key) { return kept_.find(key); }

void ColumnCache::keep(const Key& key, const Vector& column) {
  constexpr std::size_t kMaxBytes = std::size_t{16} << 20U;
  const auto bytes = sizeof(double) * static_cast<std::size_t>(column.size() + 32);
  kept_.keep(key, column, kMaxBytes / bytes + 1);
}

namespace {

/// The part of a column's key that all columns of a regression share.
ColumnCache::Key shared_key(const Structure& structure, const SearchPoint& searched) {
  ColumnCache::Key key;
  unsigned bit = 1;
  for (const TranslationEffect& effect : model::kTranslationEffects) {
    if (effect.reshape != nullptr && has(structure, effect.name)) {
      key.reshaped_by |= bit;
      key.reshapes[slot_of(effect)] = searched[slot_of(effect)];
    }
    bit <<= 1U;
  }
  for (std::size_t k = 0; k < kSearched; ++k) {
    if (slots()[k].parameter().start == model::Start::kWindSpeed) {
      key.reshapes[k] = searched[k];
    }
  }
  return key;
}

}  // namespace

Regression::Regression(const TranslationBlocks& part, const Structure& structure, const SearchPoint& searched,
                       ColumnCache* cache)
    : part_(part),
      data_(*part.data),
      structure_(structure),
      searched_(searched),
      series_(cache == nullptr ? &own_ : &cache->series()) {
  const auto rows = static_cast<Eigen::Index>(part.rows);
  base.resize(rows);
  columns.resize(rows, static_cast<Eigen::Index>(linear_count(structure)));
  ColumnCache::Key key = shared_key(structure, searched);
  take(key, cache, base, false, [](const model::Moment& at) {
    const model::Acceleration& thrust = at.thrust_w_m_s2;
    return model::Acceleration{thrust[0], thrust[1], thrust[2] - kStandardGravity_m_s2};
  });
  Eigen::Index column = 0;
  for (const std::string& name : structure) {
    const std::size_t count = linear_count(structure, name);
    const TranslationEffect* effect = model::translation_effect(name);
    for (std::size_t k = 0; k < count; ++k) {
      const double value = effect->searched_count() > 0 ? searched[slot_of(*effect)] : 0.0;
      key.effect = effect->name;
      key.which = k;
      key.value = value;
      take(key, cache, columns.col(column++), effect->acts != model::Acts::kInThrust,
           [&](const model::Moment& at) { return effect->column(k, at, value); });
    }
  }
}

void Regression::make_moments() {
  has_moments_ = true;
  const std::size_t size = data_.valid.size();
  series_->thrust = data_.thrust;
  series_->direction = data_.direction;
  series_->spare.resize(size);
  std::vector<double>& thrust = series_->thrust;
  std::array<std::vector<double>, 3>& direction = series_->direction;
  const model::ThrustSeries series{data_.period_s, thrust, {direction[0], direction[1], direction[2]}, series_->spare};
  for (const TranslationEffect& effect : model::kTranslationEffects) {
    if (effect.reshape != nullptr && has(structure_, effect.name)) {
      effect.reshape(series, searched_[slot_of(effect)]);
    }
  }
  const std::array<double, 3> wind = wind_of(searched_);
  series_->moments.resize(size);
  for (std::vector<double>& raw : series_->raw) {
    raw.resize(size);
  }
  for (const TranslationBlocks::Block& block : part_.blocks) {
    const std::size_t begin = block.samples.front() - data_.margin;
    const std::size_t end = block.samples.back() + data_.margin + 1;
    const bool follows = !spans_.empty() && begin <= spans_.back().second && begin >= spans_.back().first;
    if (follows) {
      spans_.back().second = std::max(spans_.back().second, end);
    } else {
      spans_.emplace_back(begin, end);
    }
  }
  for (const auto& [begin, end] : spans_) {
    for (std::size_t i = begin; i < end; ++i) {
      model::Moment& at = series_->moments[i];
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
}

template <typename Column, typename Law>
void Regression::take(ColumnCache::Key key, ColumnCache* cache, Column&& out, bool outer, Law&& law) {
  if (const Vector* const known = cache == nullptr ? nullptr : cache->find(key); known != nullptr) {
    out = *known;
    return;
  }
  fill(out, outer, law);
  if (cache != nullptr) {
    cache->keep(key, out);
  }
}

template <typename Column, typename Law>
void Regression::fill(Column&& out, bool outer, Law&& law) {
  const bool partly = outer && data_.projection != ForceProjection::kWholeForce;
  if (!has_moments_) {
    make_moments();
  }
  for (const auto& [begin, end] : spans_) {
    for (std::size_t i = begin; i < end; ++i) {
      const model::Acceleration whole = law(series_->moments[i]);
      const model::Acceleration u = partly ? projection(whole, series_->moments[i]) : whole;
      for (std::size_t c = 0; c < data_.axes; ++c) {
        series_->raw[c][i] = u[c];
      }
    }
  }
  for (const TranslationBlocks::Block& block : part_.blocks) {
    std::size_t row = block.row;
    for (std::size_t c = 0; c < data_.axes; ++c) {
      for (const std::size_t i : block.samples) {
        out(static_cast<Eigen::Index>(row++)) = data_.filtered(series_->raw[c], i);
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
