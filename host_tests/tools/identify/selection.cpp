// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/tools/identify/selection.h"

#include <algorithm>
#include <cmath>
#include <numeric>

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
  return out;
}

bool convincing(const Comparison& comparison, const SelectionOptions& options) {
  return comparison.cv_gain > options.minimum_cv_gain && comparison.delta_bic > options.minimum_delta_bic &&
         (comparison.t > options.minimum_t ||
          (comparison.delta_bic > options.strong_delta_bic && comparison.t > options.minimum_t_strong));
}

struct Tried {
  Family::Edit edit;
  Judged judged;
  Comparison comparison;
  bool accepted = false;
};

std::vector<Tried> try_edits(const Family& family, const Judged& present, const std::vector<std::string>& banned,
                             const SelectionOptions& options) {
  const double samples = static_cast<double>(sample_count(family));
  std::vector<Tried> tried;
  for (Family::Edit& edit : family.edits(present.fit.structure)) {
    if (std::find(banned.begin(), banned.end(), edit.name) != banned.end()) {
      continue;
    }
    Tried candidate{edit, judge(family, edit.structure, &present.fit, options.folds), {}, false};
    candidate.comparison = compare(present, candidate.judged, samples);
    candidate.accepted =
        convincing(candidate.comparison, options) && family.big_enough(candidate.judged.fit, edit.name);
    tried.push_back(std::move(candidate));
  }
  std::sort(tried.begin(), tried.end(), [](const Tried& a, const Tried& b) { return a.judged.cv < b.judged.cv; });
  return tried;
}

// Drops earlier effects that no longer earn their place beside the later ones.
void retest(const Family& family, Selection& selection, std::vector<std::string>& banned,
            const SelectionOptions& options) {
  if (selection.steps.size() < 2) {
    return;
  }
  for (std::size_t at = 0; at + 1 < selection.steps.size();) {
    const std::string name = selection.steps[at].name;
    const Structure reduced = family.without(selection.final_model.fit.structure, name);
    if (reduced == selection.final_model.fit.structure) {
      ++at;
      continue;
    }
    const Judged judged = judge(family, reduced, &selection.final_model.fit, options.folds);
    const double gain = 1.0 - selection.final_model.cv / judged.cv;
    if (gain < options.keep_cv_gain) {
      selection.final_model = judged;
      selection.steps.erase(selection.steps.begin() + static_cast<std::ptrdiff_t>(at));
      banned.push_back(name);
    } else {
      ++at;
    }
  }
}

void note_rivals(const Family& family, const std::vector<Tried>& tried, const Tried& winner, Step& step,
                 Selection& selection, std::vector<std::string>& banned, const SelectionOptions& options) {
  for (const Tried& other : tried) {
    if (&other == &winner) {
      continue;
    }
    const double ratio = other.judged.cv / winner.judged.cv;
    const bool alias = family.alias(winner.judged.fit, winner.edit.name, other.edit.name);
    if (alias) {
      banned.push_back(other.edit.name);
      step.alias_of_rival = true;
    }
    if (alias || (other.accepted && ratio < 1.0 + options.rival_margin)) {
      step.rivals.push_back({other.edit.name, other.judged.fit, ratio});
      selection.not_separable.push_back({winner.edit.name, other.edit.name});
    }
  }
}

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

double information_criterion(double mean_square, double effective_samples, std::size_t parameters) {
  return effective_samples * std::log(std::max(mean_square, 1e-300)) +
         static_cast<double>(parameters) * std::log(std::max(effective_samples, 2.0));
}

Judged judge(const Family& family, const Structure& structure, const Fit* warm, std::size_t folds) {
  const std::size_t blocks = family.block_count();
  Judged out;
  const std::vector<int> all(blocks, 1);
  out.fit = family.fit(structure, all, warm);
  out.effective_samples = effective_sample_size(family.errors(out.fit, all));
  out.cv_block.assign(blocks, 0.0);
  const std::size_t used = std::min(folds, blocks);
  for (std::size_t fold = 0; fold < used; ++fold) {
    std::vector<int> kept(blocks, 1);
    std::vector<int> left_out(blocks, 0);
    for (std::size_t block = fold; block < blocks; block += used) {
      kept[block] = used > 1 ? 0 : 1;
      left_out[block] = 1;
    }
    const Fit fitted = family.fit(structure, kept, &out.fit);
    const std::vector<std::vector<double>> errors = family.errors(fitted, left_out);
    for (std::size_t block = fold; block < blocks; block += used) {
      out.cv_block[block] = sum_of_squares(errors[block]);
    }
  }
  out.cv = std::accumulate(out.cv_block.begin(), out.cv_block.end(), 0.0);
  return out;
}

Selection select(const Family& family, const Structure& declared, const SelectionOptions& options) {
  Selection selection;
  selection.declared = judge(family, declared, nullptr, options.folds);
  selection.final_model = selection.declared;
  std::vector<std::string> banned;
  int round = 0;
  while (selection.steps.size() < options.maximum_effects) {
    const std::vector<Tried> tried = try_edits(family, selection.final_model, banned, options);
    const auto winner = std::find_if(tried.begin(), tried.end(), [](const Tried& t) { return t.accepted; });
    for (const Tried& one : tried) {
      selection.table.push_back({round, one.edit.name, one.comparison.cv_gain, one.comparison.delta_bic,
                                 one.comparison.t, family.big_enough(one.judged.fit, one.edit.name), one.accepted,
                                 winner != tried.end() && &one == &*winner});
    }
    if (winner == tried.end()) {
      break;
    }
    if (options.progress) {
      options.progress("round " + std::to_string(round + 1) + ": " + winner->edit.name);
    }
    Step step{
        winner->edit.name, winner->comparison.cv_gain, winner->comparison.delta_bic, winner->comparison.t, {}, false};
    note_rivals(family, tried, *winner, step, selection, banned, options);
    selection.steps.push_back(std::move(step));
    selection.final_model = winner->judged;
    retest(family, selection, banned, options);
    ++round;
  }
  return selection;
}

}  // namespace m100::tools::identify
