// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/residual_tests/axis/weak_effect.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "host_tests/lab/identify/residual_tests/axis/axis_change_point.h"
#include "host_tests/lab/identify/residual_tests/axis/intersample_hypotheses.h"
#include "host_tests/lab/identify/residual_tests/score_test.h"

namespace m100::lab::identify {
namespace {

struct Fitted {
  Fit fit;  ///< with the parameters of the whitened fit
  WhitenedFit white;
};

Fitted fitted(const FreeRun& run, const AxisFamily& family, const Fit& start) {
  WhitenedFit white = fit_to_convergence(run, family.model(start), free_parameters_within_row(family, start));
  Fit fit = family.with_parameters_of(start, white.before);
  return {std::move(fit), std::move(white)};
}

/// The fit, and if it has variants (such as a jump at a dead zone's edge) also the fit without them, because a variant
/// can imitate another effect.
std::vector<Fitted> shapes_of(const FreeRun& run, const AxisFamily& family, const Fit& fit) {
  std::vector<Fitted> out{fitted(run, family, fit)};
  if (!fit.shape.empty()) {
    Fit plain = fit;
    plain.shape.clear();
    out.push_back(fitted(run, family, plain));
  }
  return out;
}

/// The score of the likeliest of several fits under one hypothesis.
double score_of(const FreeRun& run, const AxisFamily& family, const std::vector<Fit>& starts) {
  double best = std::numeric_limits<double>::infinity();
  for (const Fit& start : starts) {
    best = std::min(best, fitted(run, family, start).white.score);
  }
  return best;
}

class WeakEffectSearch {
 public:
  WeakEffectSearch(const IntersampleHypotheses& hypotheses, const AxisFamily& family, const Fit& fit)
      : hypotheses_(hypotheses), family_(family), shapes_(shapes_of(hypotheses.as_logged(), family, fit)) {}

  std::optional<WeakEffect> run() {
    std::vector<StartingPoint> promising;
    double asked = 0.0;
    for (const Fitted& shape : shapes_) {
      const FreeRun& log = hypotheses_.as_logged();
      const ScoreTest left(log, shape.white, free_parameters_within_row(family_, shape.fit));
      for (const Family::Edit& edit : family_.edits(shape.fit.structure)) {
        for (const Fit& start : family_.starts_with_effect(edit, shape.fit)) {
          asked += 1.0;
          if (left.statistic(log.error(family_.model(start))) > kPromising) {
            promising.push_back({edit.name, &shape, start});
          }
        }
      }
    }
    chance_ = 2.0 * std::log(std::max(1.0, asked) / kFalseAlarm);
    for (const StartingPoint& one : promising) {
      consider(one.name, *one.shape, one.start);
    }
    return out_;
  }

 private:
  static constexpr double kFalseAlarm = 0.001;  // the probability that any test of one log exceeds chance_
  static constexpr double kPromising = 8.0;     // of one linear step; the fit that starts there gains more

  struct StartingPoint {
    std::string name;
    const Fitted* shape;
    Fit start;
  };

  void consider(const std::string& name, const Fitted& shape, const Fit& start) {
    const FreeRun& log = hypotheses_.as_logged();
    const Fitted with = fitted(log, family_, start);
    const double more =
        static_cast<double>(with.fit.parameters.size()) - static_cast<double>(shape.fit.parameters.size());
    const double price = std::max(0.0, more) * std::log(static_cast<double>(log.size()));  // among effects
    double ratio = shapes_.front().white.score - with.white.score;
    for (const Fitted& other : shapes_) {
      ratio = std::min(ratio, other.white.score - with.white.score);
    }
    if (ratio < chance_ || (out_ && ratio - price < worth_) || !family_.is_significant(with.fit, name) ||
        sharpens_rows(log.data(), family_.model(with.fit))) {
      return;
    }
    // The fits without the effect start from this fit's other parameters, too. Otherwise one that has not converged
    // would count as evidence for the effect.
    std::vector<Fit> without{family_.with_parameters_of(shape.fit, with.white.before)};
    ratio = std::min(ratio, score_of(log, family_, without) - with.white.score);
    for (const Fitted& other : shapes_) {
      without.push_back(other.fit);
    }
    if (ratio > chance_) {
      ratio = std::min(ratio, hypotheses_.min_over_held([&](const FreeRun& run) {
        return score_of(run, family_, without) - score_of(run, family_, {with.fit});
      }));
    }
    if (ratio > chance_ && (!out_ || ratio - price > worth_)) {
      out_ = WeakEffect{name, ratio};
      worth_ = ratio - price;
    }
  }

  const IntersampleHypotheses& hypotheses_;
  const AxisFamily& family_;
  std::vector<Fitted> shapes_;
  /// Ratio that the best of all tests exceeds by chance in one log of a thousand: the union of the tails of chi-square
  /// with two degrees of freedom, exp(-ratio / 2). No effect adds more than two parameters.
  double chance_ = 0.0;
  double worth_ = 0.0;  ///< of out_: its ratio less the Schwarz penalty of its parameters
  std::optional<WeakEffect> out_;
};

}  // namespace

std::optional<WeakEffect> weak_effect(const AxisData& data, const std::vector<Range>& ranges, const AxisFamily& family,
                                      const Fit& fit) {
  constexpr double kMin_s = 10.0;
  const IntersampleHypotheses hypotheses(data, ranges, family.model(fit));
  return hypotheses.as_logged().seconds() < kMin_s ? std::nullopt : WeakEffectSearch(hypotheses, family, fit).run();
}

}  // namespace m100::lab::identify
