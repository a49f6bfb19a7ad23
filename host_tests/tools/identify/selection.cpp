// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/tools/identify/selection.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "firmware/core/eigen.h"
// After our eigen.h, which redirects the checks.
#include <Eigen/Cholesky>

namespace m100::tools::identify {
namespace {

double sum_of_squares(const std::vector<double>& values) {
  return std::inner_product(values.begin(), values.end(), values.begin(), 0.0);
}

std::size_t sample_count(const Family& family) {
  std::size_t total = 0;
  for (std::size_t block = 0; block < family.block_count(); ++block) {
    total += family.samples_in(block);
  }
  return total;
}

double paired_t(const std::vector<double>& without, const std::vector<double>& with) {
  const double n = static_cast<double>(without.size());
  double mean = 0.0;
  for (std::size_t block = 0; block < without.size(); ++block) {
    mean += (without[block] - with[block]) / n;
  }
  double variance = 0.0;
  for (std::size_t block = 0; block < without.size(); ++block) {
    const double offset = without[block] - with[block] - mean;
    variance += offset * offset / std::max(1.0, n - 1.0);
  }
  return variance > 0.0 ? mean / std::sqrt(variance / n) : 0.0;
}

struct Comparison {
  double cv_gain = 0.0;
  double delta_bic = 0.0;
  double delta_white = 0.0;
  double t = 0.0;
};

// Both criteria on the effective sample size of the better-explained residual: the one without the effect is coloured
// by the very effect that is asked about.
Comparison compare(const Judged& without, const Judged& with, double samples) {
  Comparison out;
  out.cv_gain = 1.0 - with.cv / without.cv;
  const double effective = with.effective_samples;
  out.delta_bic = information_criterion(without.fit.sum_of_squares / samples, effective, without.fit.free_parameters) -
                  information_criterion(with.fit.sum_of_squares / samples, effective, with.fit.free_parameters);
  out.t = paired_t(without.cv_block, with.cv_block);
  if (out.cv_gain > 0.0 && !with.errors.empty() && !without.errors.empty()) {
    const std::size_t more = with.fit.free_parameters, fewer = without.fit.free_parameters;
    out.delta_white = whitened_criterion(without.errors, with.errors, more > fewer ? more - fewer : 0);
  }
  return out;
}

bool convincing(const Comparison& comparison, const SelectionOptions& options) {
  if (comparison.cv_gain <= options.minimum_cv_gain) {
    return false;
  }
  const double least_t = comparison.delta_bic > 0.0 ? options.minimum_t_white : options.minimum_t;
  if (comparison.t > least_t && comparison.delta_white > options.minimum_delta_white) {
    return true;
  }
  return comparison.delta_bic > options.minimum_delta_bic &&
         (comparison.t > options.minimum_t ||
          (comparison.delta_bic > options.strong_delta_bic && comparison.t > options.minimum_t_strong));
}

struct Tried {
  Family::Edit edit;
  Judged judged;
  Comparison comparison;
  bool accepted = false;
};

/// The search itself: what was found so far, and the moves that change it.
class Search {
 public:
  Search(const Family& family, const SelectionOptions& options)
      : family_(family), options_(options), samples_(static_cast<double>(sample_count(family))) {}

  Selection run(const Structure& declared) {
    out_.declared = judge(family_, declared, nullptr, options_.folds);
    out_.final_model = out_.declared;
    // A swap may open the way for another addition; the bound only guards against a cycle.
    for (int pass = 0; pass < 4; ++pass) {
      while (out_.steps.size() < options_.maximum_effects && (add_one() || add_two())) {
        retest();
      }
      if (!split_one() && !swap_or_note_rivals()) {
        break;
      }
    }
    return std::move(out_);
  }

 private:
  bool banned(const std::string& name) const {
    return std::find(banned_.begin(), banned_.end(), name) != banned_.end();
  }

  Tried try_edit(const Judged& from, const Family::Edit& edit) const {
    Tried tried{edit, {}, {}, false};
    tried.judged.fit = family_.fit(edit.structure, std::vector<int>(family_.block_count(), 1), &from.fit);
    // An edit that does not even fit better cannot predict better: its cross validation would be time wasted.
    const double kept = tried.judged.fit.sum_of_squares / from.fit.sum_of_squares;
    if (1.0 - kept < options_.minimum_cv_gain) {
      tried.judged.cv_block = from.cv_block;
      tried.judged.cv = from.cv * std::min(1.0, kept);
      tried.judged.effective_samples = from.effective_samples;
      tried.comparison = compare(from, tried.judged, samples_);
      return tried;
    }
    cross_validate(family_, tried.judged, options_.folds);
    tried.comparison = compare(from, tried.judged, samples_);
    tried.accepted = convincing(tried.comparison, options_) && family_.big_enough(tried.judged.fit, edit.name);
    return tried;
  }

  std::vector<Tried> try_edits(const Judged& from) const {
    std::vector<Tried> tried;
    for (const Family::Edit& edit : family_.edits(from.fit.structure)) {
      if (!banned(edit.name)) {
        tried.push_back(try_edit(from, edit));
      }
    }
    std::sort(tried.begin(), tried.end(), [](const Tried& a, const Tried& b) { return a.judged.cv < b.judged.cv; });
    return tried;
  }

  // The best accepted one; a simpler one that is as good comes first.
  const Tried* winner_of(const std::vector<Tried>& tried) const {
    const Tried* winner = nullptr;
    for (const Tried& one : tried) {
      if (!one.accepted) {
        continue;
      }
      if (winner == nullptr) {
        winner = &one;
      } else if (one.judged.fit.free_parameters < winner->judged.fit.free_parameters &&
                 one.judged.cv < winner->judged.cv * (1.0 + options_.simpler_margin)) {
        winner = &one;
      }
    }
    return winner;
  }

  void take(const Tried& winner) {
    Step step;
    step.name = winner.edit.name;
    step.cv_gain = winner.comparison.cv_gain;
    step.delta_bic = winner.comparison.delta_bic;
    step.paired_t = winner.comparison.t;
    out_.steps.push_back(std::move(step));
    out_.final_model = winner.judged;
    const Fit polished = family_.polish(winner.judged.fit, std::vector<int>(family_.block_count(), 1));
    if (polished.sum_of_squares < 0.995 * winner.judged.fit.sum_of_squares) {
      const Judged judged = judge(family_, polished.structure, &polished, options_.folds);
      if (judged.cv < out_.final_model.cv) {
        out_.final_model = judged;
      }
    }
    if (options_.progress) {
      options_.progress("found " + winner.edit.name);
    }
  }

  bool add_one() {
    last_tried_ = try_edits(out_.final_model);
    const Tried* winner = winner_of(last_tried_);
    for (const Tried& one : last_tried_) {
      out_.table.push_back({round_, one.edit.name, one.comparison.cv_gain, one.comparison.delta_bic,
                            one.comparison.delta_white, one.comparison.t,
                            family_.big_enough(one.judged.fit, one.edit.name), one.accepted, &one == winner});
    }
    ++round_;
    if (winner == nullptr) {
      return false;
    }
    for (const Tried& other : last_tried_) {
      if (&other != winner && family_.alias(winner->judged.fit, winner->edit.name, other.edit.name)) {
        banned_.push_back(other.edit.name);
        aliases_.push_back({winner->edit.name, other.edit.name, other.judged.fit, other.judged.cv / winner->judged.cv});
      }
    }
    take(*winner);
    return true;
  }

  struct Pair {
    const Tried* first;
    Tried second;
    Comparison first_beside_second;
  };

  // Two effects may hide each other (a dead zone and a trim): each must convince beside the other. `tried` are the
  // single edits of `from`, best first.
  std::optional<Pair> best_pair(const Judged& from, const std::vector<Tried>& tried) const {
    std::vector<const Tried*> first;
    for (const Tried& one : tried) {
      if (first.size() < options_.pair_candidates && family_.big_enough(one.judged.fit, one.edit.name)) {
        first.push_back(&one);
      }
    }
    std::optional<Pair> best;
    for (std::size_t a = 0; a < first.size(); ++a) {
      for (const Family::Edit& edit : family_.edits(first[a]->judged.fit.structure)) {
        const auto other = std::find_if(first.begin() + static_cast<std::ptrdiff_t>(a) + 1, first.end(),
                                        [&](const Tried* one) { return one->edit.name == edit.name; });
        if (other == first.end() || family_.alias(first[a]->judged.fit, first[a]->edit.name, edit.name)) {
          continue;
        }
        Tried second = try_edit(first[a]->judged, edit);
        if (!second.accepted || (best && second.judged.cv >= best->second.judged.cv)) {
          continue;
        }
        const Comparison beside = compare((*other)->judged, second.judged, samples_);
        const Comparison both = compare(from, second.judged, samples_);
        if (convincing(beside, options_) && convincing(both, options_) && both.delta_bic > options_.strong_delta_bic &&
            family_.big_enough(second.judged.fit, first[a]->edit.name)) {
          best = Pair{first[a], std::move(second), beside};
        }
      }
    }
    return best;
  }

  void take_pair(const Pair& pair) {
    Step step;
    step.name = pair.first->edit.name;
    step.cv_gain = pair.first_beside_second.cv_gain;
    step.delta_bic = pair.first_beside_second.delta_bic;
    step.paired_t = pair.first_beside_second.t;
    out_.steps.push_back(std::move(step));
    for (const auto& [name, comparison] : {std::pair{pair.first->edit.name, pair.first_beside_second},
                                           std::pair{pair.second.edit.name, pair.second.comparison}}) {
      out_.table.push_back({round_, name, comparison.cv_gain, comparison.delta_bic, comparison.delta_white,
                            comparison.t, true, true, true});
    }
    ++round_;
    take(pair.second);
  }

  bool add_two() {
    if (out_.steps.size() + 2 > options_.maximum_effects) {
      return false;
    }
    const std::optional<Pair> pair = best_pair(out_.final_model, last_tried_);
    if (pair) {
      take_pair(*pair);
    }
    return pair.has_value();
  }

  // One effect that stood in for two: a gain asymmetry for a trim on a curved stick.
  bool split_one() {
    if (out_.steps.size() + 1 > options_.maximum_effects || out_.steps.size() > 2) {
      return false;
    }
    for (std::size_t at = 0; at < out_.steps.size(); ++at) {
      const Structure reduced = family_.without(out_.final_model.fit.structure, out_.steps[at].name);
      if (reduced == out_.final_model.fit.structure) {
        continue;
      }
      const Judged without = judge(family_, reduced, &out_.final_model.fit, options_.folds);
      const std::vector<Tried> tried = try_edits(without);
      const std::optional<Pair> pair = best_pair(without, tried);
      if (pair && pair->second.judged.cv < (1.0 - options_.split_gain) * out_.final_model.cv) {
        out_.steps.erase(out_.steps.begin() + static_cast<std::ptrdiff_t>(at));
        take_pair(*pair);
        return true;
      }
    }
    return false;
  }

  // Drops earlier effects that no longer earn their place beside the later ones.
  void retest() {
    for (std::size_t at = 0; at + 1 < out_.steps.size();) {
      const std::string name = out_.steps[at].name;
      const Structure reduced = family_.without(out_.final_model.fit.structure, name);
      if (reduced == out_.final_model.fit.structure) {
        ++at;
        continue;
      }
      const Judged judged = judge(family_, reduced, &out_.final_model.fit, options_.folds);
      if (1.0 - out_.final_model.cv / judged.cv < options_.keep_cv_gain) {
        out_.final_model = judged;
        out_.steps.erase(out_.steps.begin() + static_cast<std::ptrdiff_t>(at));
        banned_.push_back(name);
      } else {
        ++at;
      }
    }
  }

  // Every effect against every other edit in its place, all the rest being known: who is better takes the place, who is
  // as good is named beside it.
  bool swap_or_note_rivals() {
    for (Step& step : out_.steps) {
      step.rivals.clear();
    }
    for (std::size_t at = 0; at < out_.steps.size(); ++at) {
      const Structure reduced = family_.without(out_.final_model.fit.structure, out_.steps[at].name);
      if (reduced == out_.final_model.fit.structure) {
        continue;
      }
      const Judged without = judge(family_, reduced, &out_.final_model.fit, options_.folds);
      std::vector<Tried> others;
      for (const Family::Edit& edit : family_.edits(reduced)) {
        if (edit.name == out_.steps[at].name || (is_alias(edit.name) && !alias_of(out_.steps[at].name, edit.name))) {
          continue;
        }
        Tried tried = try_edit(without, edit);
        if (tried.accepted) {
          others.push_back(std::move(tried));
        }
      }
      for (Tried& other : others) {
        const double ratio = other.judged.cv / out_.final_model.cv;
        const bool simpler = other.judged.fit.free_parameters < out_.final_model.fit.free_parameters;
        if (ratio < 1.0 - options_.simpler_margin || (simpler && ratio < 1.0 + options_.simpler_margin)) {
          exchange_alias(out_.steps[at].name, other.edit.name, 1.0 / ratio);
          out_.steps[at].name = other.edit.name;
          out_.steps[at].cv_gain = other.comparison.cv_gain;
          out_.steps[at].delta_bic = other.comparison.delta_bic;
          out_.steps[at].paired_t = other.comparison.t;
          out_.final_model = std::move(other.judged);
          return true;
        }
        if (ratio < 1.0 + options_.rival_margin && !is_alias(other.edit.name)) {
          out_.steps[at].rivals.push_back({other.edit.name, other.judged.fit, ratio});
        }
      }
    }
    out_.not_separable.clear();
    for (Step& step : out_.steps) {
      for (const Alias& alias : aliases_) {
        if (alias.winner == step.name) {
          step.rivals.push_back({alias.name, alias.fit, alias.cv_ratio});
          step.alias_of_rival = true;
        }
      }
      for (const Step::Runner& rival : step.rivals) {
        out_.not_separable.push_back({step.name, rival.name});
      }
    }
    return false;
  }

  struct Alias {
    std::string winner, name;
    Fit fit;
    double cv_ratio;
  };
  bool is_alias(const std::string& name) const {
    return std::any_of(aliases_.begin(), aliases_.end(), [&](const Alias& alias) { return alias.name == name; });
  }

  bool alias_of(const std::string& winner, const std::string& name) const {
    return std::any_of(aliases_.begin(), aliases_.end(),
                       [&](const Alias& alias) { return alias.winner == winner && alias.name == name; });
  }
  // Two of a kind change places: the first look may have chosen the wrong one while something else was missing.
  void exchange_alias(const std::string& old_name, const std::string& new_name, double cv_ratio) {
    for (Alias& alias : aliases_) {
      if (alias.winner == old_name && alias.name == new_name) {
        alias = {new_name, old_name, out_.final_model.fit, cv_ratio};
        std::erase(banned_, new_name);
        banned_.push_back(old_name);
      }
    }
  }

  const Family& family_;
  const SelectionOptions& options_;
  double samples_;
  Selection out_;
  std::vector<Tried> last_tried_;
  std::vector<std::string> banned_;
  std::vector<Alias> aliases_;
  int round_ = 0;
};

}  // namespace

double effective_sample_size(const std::vector<std::vector<double>>& blocks) {
  double power = 0.0;
  std::size_t samples = 0;
  std::size_t longest = 0;
  for (const std::vector<double>& block : blocks) {
    power += sum_of_squares(block);
    samples += block.size();
    longest = std::max(longest, block.size());
  }
  if (samples == 0 || power <= 0.0) {
    return static_cast<double>(samples);
  }
  double time = 1.0;
  for (std::size_t lag = 1; lag < longest; ++lag) {
    double product = 0.0;
    for (const std::vector<double>& block : blocks) {
      for (std::size_t i = lag; i < block.size(); ++i) {
        product += block[i] * block[i - lag];
      }
    }
    if (product <= 0.0) {
      break;
    }
    time += 2.0 * product / power;
  }
  return std::max(1.0, static_cast<double>(samples) / time);
}

double whitened_criterion(const std::vector<std::vector<double>>& without, const std::vector<std::vector<double>>& with,
                          std::size_t extra) {
  constexpr std::size_t kThin = 5;
  constexpr int kOrder = 4;
  const auto thinned = [](const std::vector<std::vector<double>>& blocks) {
    std::vector<std::vector<double>> out;
    for (const std::vector<double>& block : blocks) {
      std::vector<double> means;
      for (std::size_t at = 0; at + kThin <= block.size(); at += kThin) {
        means.push_back(std::accumulate(block.begin() + static_cast<std::ptrdiff_t>(at),
                                        block.begin() + static_cast<std::ptrdiff_t>(at + kThin), 0.0) /
                        kThin);
      }
      out.push_back(std::move(means));
    }
    return out;
  };
  const std::vector<std::vector<double>> a = thinned(without);
  const std::vector<std::vector<double>> b = thinned(with);
  Eigen::Matrix<double, kOrder, kOrder> normal = Eigen::Matrix<double, kOrder, kOrder>::Zero();
  Eigen::Matrix<double, kOrder, 1> right = Eigen::Matrix<double, kOrder, 1>::Zero();
  for (const std::vector<double>& block : b) {
    for (std::size_t i = kOrder; i < block.size(); ++i) {
      const Eigen::Map<const Eigen::Matrix<double, kOrder, 1>> past(&block[i - kOrder]);
      normal += past * past.transpose();
      right += past * block[i];
    }
  }
  normal.diagonal() *= 1.0 + 1e-6;
  const Eigen::Matrix<double, kOrder, 1> filter = normal.ldlt().solve(right);
  double sum_a = 0.0;
  double sum_b = 0.0;
  double count = 0.0;
  for (std::size_t block = 0; block < b.size(); ++block) {
    for (std::size_t i = kOrder; i < std::min(a[block].size(), b[block].size()); ++i) {
      const Eigen::Map<const Eigen::Matrix<double, kOrder, 1>> past_a(&a[block][i - kOrder]);
      const Eigen::Map<const Eigen::Matrix<double, kOrder, 1>> past_b(&b[block][i - kOrder]);
      const double white_a = a[block][i] - filter.dot(past_a);
      const double white_b = b[block][i] - filter.dot(past_b);
      sum_a += white_a * white_a;
      sum_b += white_b * white_b;
      count += 1.0;
    }
  }
  if (!(count > 0.0 && sum_a > 0.0 && sum_b > 0.0)) {
    return 0.0;
  }
  return count * std::log(sum_a / sum_b) - static_cast<double>(extra) * std::log(count);
}

double information_criterion(double mean_square, double effective_samples, std::size_t parameters) {
  return effective_samples * std::log(std::max(mean_square, 1e-300)) +
         static_cast<double>(parameters) * std::log(std::max(effective_samples, 2.0));
}

void cross_validate(const Family& family, Judged& out, std::size_t folds) {
  const std::size_t blocks = family.block_count();
  out.errors = family.errors(out.fit, std::vector<int>(blocks, 1));
  out.effective_samples = effective_sample_size(out.errors);
  out.cv_block.assign(blocks, 0.0);
  const std::size_t used = std::min(folds, blocks);
  for (std::size_t fold = 0; fold < used; ++fold) {
    std::vector<int> kept(blocks, 1);
    std::vector<int> left_out(blocks, 0);
    for (std::size_t block = fold; block < blocks; block += used) {
      kept[block] = used > 1 ? 0 : 1;
      left_out[block] = 1;
    }
    const Fit fitted = family.fit(out.fit.structure, kept, &out.fit);
    const std::vector<std::vector<double>> errors = family.errors(fitted, left_out);
    for (std::size_t block = fold; block < blocks; block += used) {
      out.cv_block[block] = sum_of_squares(errors[block]);
    }
  }
  out.cv = std::accumulate(out.cv_block.begin(), out.cv_block.end(), 0.0);
}

Judged judge(const Family& family, const Structure& structure, const Fit* warm, std::size_t folds) {
  Judged out;
  out.fit = family.fit(structure, std::vector<int>(family.block_count(), 1), warm);
  cross_validate(family, out, folds);
  return out;
}

Selection select(const Family& family, const Structure& declared, const SelectionOptions& options) {
  return Search(family, options).run(declared);
}

}  // namespace m100::tools::identify
