// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "firmware/core/eigen.h"
#include "firmware/model/translation.h"
#include "host_tests/lab/identify/search/family.h"
#include "host_tests/lab/identify/translation/translation_data.h"

namespace m100::lab::identify::translation {

// The linear half of the models of translation. Which effects there are, and what each of them does, is declared in
// firmware/model/translation; here stand the rules for putting them together.

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

bool has(const Structure& structure, std::string_view name);

/// A parameter that is searched because the prediction is not linear in it.
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
/// All of them, in the order of their turns.
const std::array<Slot, kSearched>& slots();
/// Index into slots() of an effect's first searched parameter, which it must have.
std::size_t slot_of(const model::TranslationEffect& effect);

/// One value for each slot, 0 where the structure does not have the effect. It is also the head of a fit's parameters,
/// which the linear ones follow in the order of the structure.
using Searched = std::array<double, kSearched>;
/// The head of a fit's parameters. Precondition: at least kSearched of them.
Searched searched_of(const Fit& fit);
/// Which slots a fit of the structure has to search.
std::array<bool, kSearched> searched_in(const Structure& structure);
/// With wind and a progressive drag, it is the wind's speed that is searched and not its acceleration that is linear.
bool wind_speed_matters(const Structure& structure);
/// The wind's velocity of the slots that hold one.
std::array<double, 3> wind_of(const Searched& searched);

/// How many linear parameters an effect has beside the others, and all of them together.
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
  Regression(const TranslationBlocks& part, const Structure& structure, const Searched& searched);

  Vector base;
  Matrix columns;

 private:
  /// Thrust and its direction after all effects that reshape them, sample by sample, with the velocity in the air.
  void make_moments(const Structure& structure, const Searched& searched);
  /// Fills rows with the filtered acceleration u(sample), of which the log shows only a part if `outer`.
  template <typename Column, typename Law>
  void fill(Column&& out, bool outer, Law&& law);
  /// What the log shows of an outer acceleration.
  model::Acceleration shown(const model::Acceleration& u, const model::Moment& at) const;

  const TranslationBlocks& part_;
  const TranslationData& data_;
  std::vector<model::Moment> moments_;
  std::array<std::vector<double>, 3> raw_;
};

}  // namespace m100::lab::identify::translation
