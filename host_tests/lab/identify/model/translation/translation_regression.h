// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "firmware/core/eigen.h"
#include "firmware/model/translation.h"
#include "host_tests/lab/identify/data/translation_data.h"
#include "host_tests/lab/identify/model/model_family.h"

namespace m100::lab::identify::translation {

// The linear part of the models of translation. The effects are declared in firmware/model/translation; this file
// combines them into one regression.

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

bool has(const Structure& structure, std::string_view name);

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

/// One value for each slot, 0 where the structure does not have the effect. A fit's parameters begin with these values;
/// the linear parameters follow in the order of the structure.
using SearchPoint = std::array<double, kSearched>;
/// The searched parameters of a fit. Precondition: it has at least kSearched parameters.
SearchPoint searched_of(const Fit& fit);
/// Which slots a fit of the structure has to search.
std::array<bool, kSearched> searched_in(const Structure& structure);
/// Whether the structure has wind and a progressive drag: then the wind's speed is searched, instead of a linear
/// acceleration.
bool is_wind_speed_searched(const Structure& structure);
/// The wind's velocity, from the slots that hold it.
std::array<double, 3> wind_of(const SearchPoint& searched);

/// Number of linear parameters of one effect in this structure, and of all effects.
std::size_t linear_count(const Structure& structure, std::string_view name);
std::size_t linear_count(const Structure& structure);
/// Column of the first linear parameter of an effect of the structure.
std::size_t column_of(const Structure& structure, std::string_view wanted);
/// The linear parameters of an effect. Precondition: the fit's structure has it.
std::span<const double> linear_of(const Fit& fit, std::string_view name);

/// Linear models of one part of a log: y = base + columns * linear parameters.
/// Shapes: base part.rows, columns part.rows x linear_count(structure).
/// Cost: the log's samples times the columns.
class Regression {
 public:
  Regression(const TranslationBlocks& part, const Structure& structure, const SearchPoint& searched);

  Vector base;
  Matrix columns;

 private:
  /// Thrust and its direction after all effects that reshape them, sample by sample, with the velocity in the air.
  void make_moments(const Structure& structure, const SearchPoint& searched);
  /// Fills rows with the filtered acceleration u(sample); the log shows only a part of it if `outer`.
  template <typename Column, typename Law>
  void fill(Column&& out, bool outer, Law&& law);
  /// The part of an outer acceleration that the log shows.
  model::Acceleration projection(const model::Acceleration& u, const model::Moment& at) const;

  const TranslationBlocks& part_;
  const TranslationData& data_;
  std::vector<model::Moment> moments_;
  std::array<std::vector<double>, 3> raw_;
};

}  // namespace m100::lab::identify::translation
