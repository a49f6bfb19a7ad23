// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "firmware/core/eigen.h"
#include "firmware/model/translation.h"
#include "host_tests/lab/identify/data/translation_data.h"
#include "host_tests/lab/identify/model/model_family.h"
#include "host_tests/lab/identify/model/translation/recently_used.h"

namespace m100::lab::identify::translation {

// The linear part of the models of translation. The effects are declared in firmware/model/translation; this file
// combines them into one regression.

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

/// A searched parameter: the prediction is not linear in it.
struct Slot {
  const model::TranslationEffect* effect = nullptr;
  std::size_t which = 0;  ///< of the effect's searched parameters
  const model::SearchedParameter& parameter() const { return effect->searched[which]; }
};
inline constexpr std::size_t kSearched = [] {
  std::size_t count = 0;
  for (const model::TranslationEffect& effect : model::kTranslationEffects) {
    count += effect.searched_count();
  }
  return count;
}();
/// All slots, in the order in which they are searched.
const std::array<Slot, kSearched>& slots();
/// Index into slots() of an effect's first searched parameter, which it must have.
std::size_t slot_of(const model::TranslationEffect& effect);

/// One value for each parameter that any effect declares as searched, 0 if the structure does not search it. A fit's
/// parameters begin with these values; the linear parameters follow in the order of the structure.
using SearchPoint = std::array<double, kSearched>;
/// The searched parameters of a fit. Precondition: it has at least kSearched parameters.
SearchPoint searched_of(const Fit& fit);
/// Which slots a fit of the structure has to search.
std::array<bool, kSearched> searched_in(const Structure& structure);
/// Whether the structure has wind and a progressive drag: then the wind's speed is searched, not an acceleration.
bool is_wind_speed_searched(const Structure& structure);
/// The wind's velocity in the world frame [m/s]; zero where it is not searched.
std::array<double, 3> wind_of(const SearchPoint& searched);

/// Number of linear parameters of one effect in this structure, and of all effects.
std::size_t linear_count(const Structure& structure, std::string_view name);
std::size_t linear_count(const Structure& structure);
/// Column of the first linear parameter of an effect of the structure.
std::size_t column_of(const Structure& structure, std::string_view wanted);
/// The linear parameters of an effect. Precondition: the fit's structure has it.
std::span<const double> linear_of(const Fit& fit, std::string_view name);

/// Buffers of the length of the log, which every regression overwrites.
struct MomentSeries {
  std::vector<model::Moment> moments;  ///< only where a block needs them
  std::vector<double> thrust;
  std::array<std::vector<double>, 3> direction;
  std::vector<double> spare;
  std::array<std::vector<double>, 3> raw;
};

/// Cache of the filtered columns used last, about 16 MiB, for one part of a log. Most columns of a regression are those
/// of the one before, because a step of the search changes one parameter and an edit adds one effect.
class ColumnCache {
 public:
  /// What determines a column: its effect (empty: the thrust itself), which of the effect's columns it is, the effect's
  /// own searched value, and the effects and searched values that reshape thrust and air velocity.
  struct Key {
    std::string_view effect;
    std::size_t which = 0;
    double value = 0.0;
    unsigned reshaped_by = 0;  ///< one bit for each effect that reshapes the thrust
    SearchPoint reshapes{};    ///< the searched values of those effects and of the wind
    bool operator==(const Key&) const = default;
  };
  struct Hash {
    std::size_t operator()(const Key& key) const;
  };
  /// nullptr: not known. Valid until the next keep().
  const Vector* find(const Key& key);
  void keep(const Key& key, const Vector& column);
  MomentSeries& series() { return series_; }

 private:
  RecentlyUsed<Key, Vector, Hash> kept_;
  MomentSeries series_;
};

/// Linear models of one part of a log: y = base + columns * linear parameters.
/// Shapes: base part.rows, columns part.rows x linear_count(structure).
/// Cost: the log's samples times the columns.
class Regression {
 public:
  /// @param cache  of this part, or nullptr
  Regression(const TranslationBlocks& part, const Structure& structure, const SearchPoint& searched,
             ColumnCache* cache = nullptr);

  Vector base;
  Matrix columns;

 private:
  /// Computes the velocity in the air and, after all effects that reshape them, the thrust and its direction. It is
  /// called when the first column needs them.
  void make_moments();
  /// Copies a column from the cache to `out`; fills `out` if the cache does not have it.
  template <typename Column, typename Law>
  void take(ColumnCache::Key key, ColumnCache* cache, Column&& out, bool outer, Law&& law);
  /// Fills `out` with the filtered acceleration `law`; of an external (`outer`) one only the part that the residual
  /// shows.
  template <typename Column, typename Law>
  void fill(Column&& out, bool outer, Law&& law);
  /// The part of an external acceleration that the residual shows (ForceProjection).
  model::Acceleration projection(const model::Acceleration& u, const model::Moment& at) const;

  const TranslationBlocks& part_;
  const TranslationData& data_;
  const Structure& structure_;
  const SearchPoint& searched_;
  MomentSeries own_;      ///< where there is no cache
  MomentSeries* series_;  ///< of the cache, or own_
  bool has_moments_ = false;
  std::vector<std::pair<std::size_t, std::size_t>> spans_;  ///< samples [first, second) that the blocks' filters reach
};

}  // namespace m100::lab::identify::translation
