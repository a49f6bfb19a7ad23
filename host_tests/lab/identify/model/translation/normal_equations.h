// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "host_tests/lab/identify/model/translation/translation_regression.h"

namespace m100::lab::identify::translation {

/// Normal equations of one regression for each block. The sum of squared errors of a block for the parameters x is
/// square - 2 right' x + x' normal x.
struct BlockNormals {
  std::vector<Matrix> normal;
  std::vector<Vector> right;
  std::vector<double> square;
};

/// Cache of the normal equations used last, about 16 MiB. The folds of a cross-validation, the groups of the jackknife
/// and the steps of a search need the same ones repeatedly.
class NormalEquations {
 public:
  /// `part` and `measured` (part.rows values) must be the same in every call. The result is valid until the next call.
  const BlockNormals& of(const TranslationBlocks& part, const Vector& measured, const Structure& structure,
                         const SearchPoint& searched);

 private:
  struct Key {
    Structure structure;
    SearchPoint searched{};
    bool operator==(const Key&) const = default;
  };
  struct Hash {
    std::size_t operator()(const Key& key) const;
  };
  RecentlyUsed<Key, BlockNormals, Hash> kept_;
  ColumnCache columns_;
};

}  // namespace m100::lab::identify::translation
