// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/residual_tests/translation/translation_change_point.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "firmware/model/translation.h"
#include "host_tests/lab/identify/model/translation/coordinate_search.h"
#include "host_tests/lab/identify/model/translation/translation_family.h"
#include "host_tests/lab/identify/model/translation/translation_regression.h"
#include "host_tests/lab/identify/residual_tests/change_scan.h"
#include "host_tests/lab/printed.h"

namespace m100::lab::identify::translation {
namespace {

using logs::Signal;
using model::TranslationEffect;

constexpr std::size_t kThin = 3;  // every third row of 40 ms: the filter over 0.2 s leaves no more detail

/// One row of a scan: which part, which row of its regressions, which sample of its log, which axis.
struct ScanRow {
  const TranslationDataSet* part;
  Eigen::Index row;
  std::size_t sample;
  std::size_t axis;
};

struct ScanLayout {
  std::vector<ScanRow> rows;
  std::vector<Segment> segments;
};

/// The rows of one axis of all parts in the order of time, every kThin-th.
std::vector<ScanRow> thinned(const std::vector<const TranslationDataSet*>& parts, std::size_t axis) {
  std::vector<ScanRow> all;
  for (const TranslationDataSet* part : parts) {
    for (const TranslationBlocks::Block& block : part->blocks.blocks) {
      for (std::size_t k = 0; k < block.samples.size(); ++k) {
        const auto row = static_cast<Eigen::Index>(block.row + axis * block.samples.size() + k);
        all.push_back({part, row, block.samples[k], axis});
      }
    }
  }
  std::stable_sort(all.begin(), all.end(), [](const ScanRow& a, const ScanRow& b) { return a.sample < b.sample; });
  std::vector<ScanRow> out;
  for (std::size_t k = 0; k < all.size(); k += kThin) {
    out.push_back(all[k]);
  }
  return out;
}

double time_s(const ScanRow& place) { return place.part->data.time_s(place.sample); }

/// The rows of all axes, one axis after the other; a segment ends with its axis, and at a hole in the log.
ScanLayout scan_layout(const std::vector<const TranslationDataSet*>& parts) {
  ScanLayout out;
  const double longest_s = 1.5 * static_cast<double>(kThin) * parts.front()->blocks.sample_period_s;
  for (std::size_t c = 0; c < parts.front()->data.axes; ++c) {
    for (const ScanRow& place : thinned(parts, c)) {
      const auto row = static_cast<Eigen::Index>(out.rows.size());
      const bool goes_on =
          !out.segments.empty() && out.rows.back().axis == c && time_s(place) - time_s(out.rows.back()) < longest_s;
      if (!goes_on) {
        out.segments.push_back({row, row});
      }
      out.segments.back().end = row + 1;
      out.rows.push_back(place);
    }
  }
  return out;
}

/// The regressor matrix of a structure's linear parameters, with one row for each row of the scan.
Columns columns_of(const ScanLayout& layout, const std::vector<const TranslationDataSet*>& parts,
                   const Structure& structure, const SearchPoint& searched) {
  Columns out(static_cast<Eigen::Index>(layout.rows.size()), static_cast<Eigen::Index>(linear_count(structure)));
  for (const TranslationDataSet* part : parts) {
    const Regression model(part->blocks, structure, searched);
    for (std::size_t k = 0; k < layout.rows.size(); ++k) {
      if (layout.rows[k].part == part) {
        out.row(static_cast<Eigen::Index>(k)) = model.columns.row(layout.rows[k].row);
      }
    }
  }
  return out;
}

ScanRows rows_of(const ScanLayout& layout, const std::vector<const TranslationDataSet*>& parts, const Fit& fit) {
  ScanRows out;
  out.segments = layout.segments;
  out.residual.resize(static_cast<Eigen::Index>(layout.rows.size()));
  for (const TranslationDataSet* part : parts) {
    const Vector left = residual_of(part->blocks, measured_rows(part->blocks), fit);
    for (std::size_t k = 0; k < layout.rows.size(); ++k) {
      if (layout.rows[k].part == part) {
        out.residual(static_cast<Eigen::Index>(k)) = left(layout.rows[k].row);
      }
    }
  }
  for (const ScanRow& place : layout.rows) {
    out.time_s.push_back(time_s(place));
  }
  const SearchPoint searched = searched_of(fit);
  const Columns own = columns_of(layout, parts, fit.structure, searched);
  const Columns constant = columns_of(layout, parts, {"rigid_body", "steady_wind"}, SearchPoint{});
  out.base.resize(own.rows(), own.cols() + constant.cols());
  out.base << own, constant;
  return out;
}

/// Whether a change of the effect would show in this log. Without a heading an effect and its equivalent (wind and body
/// bias) cannot be distinguished: only the first of the two is tested.
bool is_observable(const TranslationDataSet& part, const TranslationEffect& effect) {
  const TranslationData& data = part.data;
  const TranslationEffect* equivalent = model::translation_effect(effect.equivalent);
  const bool stands_alone = data.has_yaw || equivalent == nullptr || effect.place < equivalent->place;
  return stands_alone && data.has_signals_for(effect.needs);
}

using Hit = std::pair<const TranslationEffect*, ScanHit>;

/// The effects whose change is likely and large enough, each with its scan.
std::vector<Hit> scan_hits(const std::vector<const TranslationDataSet*>& parts, const Fit& fit) {
  constexpr double kThreshold = 30.0;
  const ScanLayout layout = scan_layout(parts);
  const ScanRows rows = rows_of(layout, parts, fit);
  std::vector<Hit> hits;
  for (const TranslationEffect& effect : model::kTranslationEffects) {
    if (effect.change.name.empty() || !is_observable(*parts.front(), effect)) {
      continue;
    }
    const Columns columns = columns_of(layout, parts, {"rigid_body", std::string(effect.name)}, searched_of(fit));
    ScanHit hit = scan_change(rows, columns);
    if (hit.likelihood_ratio > kThreshold && hit.size.norm() > effect.change.min_relevant) {
      hits.emplace_back(&effect, std::move(hit));
    }
  }
  return hits;
}

/// @param hits  all changes found: those that are nearly as likely as the best are its rivals
Change change_point(const Hit& best, const std::vector<Hit>& hits, const TranslationDataSet& training) {
  constexpr double kNameMargin = 6.0;
  // The scan finds the last row before the change: the change lies between that row and the next, and the filter has
  // smeared it over its own width, with most of the weight in the middle half.
  const double cell_s = static_cast<double>(kThin) * training.blocks.sample_period_s;
  const double smeared_s = 0.5 * static_cast<double>(training.data.margin) * training.data.period_s;
  Change out;
  out.at_s = best.second.at_s + 0.5 * cell_s;
  out.low_s = best.second.low_s - smeared_s;
  out.high_s = best.second.high_s + cell_s + smeared_s;
  out.name = best.first->change.name;
  out.likelihood_ratio = best.second.likelihood_ratio;
  for (Eigen::Index k = 0; k < best.second.size.size(); ++k) {
    const std::string axis = best.second.size.size() > 1 ? (k == 0 ? "_x" : "_y") : "";
    out.parameters.push_back({"change_of_" + std::string(best.first->change.unit) + axis, best.second.size(k)});
  }
  for (const auto& [effect, hit] : hits) {
    if (effect != best.first && hit.likelihood_ratio > best.second.likelihood_ratio - kNameMargin) {
      out.rivals.emplace_back(effect->change.name);
    }
  }
  return out;
}

}  // namespace

std::vector<Change> change_points(const TranslationDataSet& training, const TranslationDataSet* validation,
                                  const Fit& fit) {
  std::vector<const TranslationDataSet*> parts{&training};
  if (validation != nullptr) {
    parts.push_back(validation);
  }
  const std::vector<Hit> hits = scan_hits(parts, fit);
  const auto best = std::max_element(hits.begin(), hits.end(), [](const Hit& a, const Hit& b) {
    return a.second.likelihood_ratio < b.second.likelihood_ratio;
  });
  return best == hits.end() ? std::vector<Change>{} : std::vector<Change>{change_point(*best, hits, training)};
}

std::vector<Finding> position_force(const TranslationDataSet& training, const Fit& fit) {
  constexpr double kThreshold = 60.0;
  constexpr double kMin_m_s2 = 0.1;
  if (!training.log.has3(Signal::kPositionX)) {
    return {};
  }
  const std::vector<const TranslationDataSet*> parts{&training};
  const ScanLayout layout = scan_layout(parts);
  const ScanRows rows = rows_of(layout, parts, fit);
  const Eigen::Index before = rows.base.cols();
  Columns all(rows.base.rows(), before + 2);
  all << rows.base, Columns::Zero(rows.base.rows(), 2);
  for (std::size_t k = 0; k < layout.rows.size(); ++k) {
    const ScanRow& place = layout.rows[k];
    if (place.axis < 2) {
      const std::vector<double>& position =
          training.log.of(logs::offset(Signal::kPositionX, static_cast<int>(place.axis)));
      all(static_cast<Eigen::Index>(k), before + static_cast<Eigen::Index>(place.axis)) =
          training.data.filtered(position, place.sample);
    }
  }
  const auto solve = [](Columns normal, const Rows& right) -> Rows {
    normal.diagonal() = normal.diagonal() * (1.0 + 1e-9) + Rows::Constant(normal.rows(), 1e-300);
    return normal.ldlt().solve(right);
  };
  const Rows left = rows.residual - all * solve(all.transpose() * all, all.transpose() * rows.residual);
  const Ar filter = autoregression(left, rows.segments);
  Rows residual = rows.residual;
  whiten(filter, rows.segments, residual);
  for (Eigen::Index c = 0; c < all.cols(); ++c) {
    whiten(filter, rows.segments, all.col(c));
  }
  const Columns base = all.leftCols(before);
  const Rows without = residual - base * solve(base.transpose() * base, base.transpose() * residual);
  const Rows solution = solve(all.transpose() * all, all.transpose() * residual);
  const Rows with = residual - all * solution;
  const double ratio =
      whitened_rows(rows.segments) * std::log(without.squaredNorm() / std::max(1e-300, with.squaredNorm()));
  double pull_m_s2 = 0.0;
  for (int c = 0; c < 2; ++c) {
    const std::vector<double>& position = training.log.of(logs::offset(Signal::kPositionX, c));
    double mean = 0.0;
    double square = 0.0;
    for (const double p : position) {
      mean += p / static_cast<double>(position.size());
      square += p * p / static_cast<double>(position.size());
    }
    pull_m_s2 = std::max(pull_m_s2, -solution(before + c) * std::sqrt(std::max(0.0, square - mean * mean)));
  }
  if (ratio < kThreshold || pull_m_s2 < kMin_m_s2) {
    return {};
  }
  const std::string text = printed(
      "a force pulls back the farther the vehicle is away (%.2f and %.2f m/s^2 per metre along x and y): a tether?",
      -solution(before), -solution(before + 1));
  return {{.what = "position_force", .signal = "position", .text = text}};
}

}  // namespace m100::lab::identify::translation
