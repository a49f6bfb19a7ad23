// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/translation/normal_equations.h"

#include <functional>
#include <string>
#include <utility>

namespace m100::lab::identify::translation {

std::size_t NormalEquations::Hash::operator()(const Key& key) const {
  std::size_t out = 0;
  for (const std::string& name : key.structure) {
    out = mixed(out, std::hash<std::string>{}(name));
  }
  for (const double value : key.searched) {
    out = mixed(out, std::hash<double>{}(value));
  }
  return out;
}

const BlockNormals& NormalEquations::of(const TranslationBlocks& part, const Vector& measured,
                                        const Structure& structure, const Searched& searched) {
  const Key key{structure, searched};
  if (const BlockNormals* const known = kept_.find(key); known != nullptr) {
    return *known;
  }
  constexpr std::size_t kMaxBytes = std::size_t{16} << 20U;
  const std::size_t n = linear_count(structure);
  const std::size_t bytes = (part.blocks.size() + 4) * sizeof(double) * (n * n + n + 16);
  const Regression model(part, structure, searched, &columns_);
  const Vector target = measured - model.base;
  BlockNormals out;
  for (const TranslationBlocks::Block& block : part.blocks) {
    const auto row = static_cast<Eigen::Index>(block.row);
    const auto count = static_cast<Eigen::Index>(block.samples.size() * part.data->axes);
    const auto columns = model.columns.middleRows(row, count);
    out.normal.emplace_back(columns.transpose() * columns);
    out.right.emplace_back(columns.transpose() * target.segment(row, count));
    out.square.push_back(target.segment(row, count).squaredNorm());
  }
  return kept_.keep(key, std::move(out), kMaxBytes / bytes + 1);
}

}  // namespace m100::lab::identify::translation
