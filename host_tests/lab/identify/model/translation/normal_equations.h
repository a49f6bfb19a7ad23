// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "host_tests/lab/identify/model/translation/translation_regression.h"

namespace m100::lab::identify::translation {

/// Normal equations of one regression for each block: with N = sum of weight * normal and so on, the error of the
/// parameters x is square - 2 right' x + x' N x.
struct BlockNormals {
  std::vector<Matrix> normal;
  std::vector<Vector> right;
  std::vector<double> square;
};

/// Normal equations of the training part. The folds of a cross-validation, the groups of the jackknife and the steps of
/// a search need the same ones again and again; the ones used last are kept, about 16 MiB of them.
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
