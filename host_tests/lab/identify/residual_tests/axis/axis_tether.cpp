// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/residual_tests/axis/axis_tether.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "host_tests/lab/identify/residual_tests/axis/axis_change_point.h"
#include "host_tests/lab/identify/residual_tests/score_test.h"
#include "host_tests/lab/printed.h"
#include "host_tests/lab/statistics.h"

namespace m100::lab::identify {
namespace {

constexpr double kThreshold = 16.0;  // the best of several tests, as for a change: one false alarm in a hundred logs
constexpr int kEdges = 10;  // evenly over the distance: an edge that is touched rarely lies beyond the quantiles

/// The distance flown: the integral of the response from the start of each flight.
std::vector<double> distance_flown(const AxisData& data) {
  std::vector<double> out(data.measured.size(), 0.0);
  double distance_m = 0.0;
  for (std::size_t i = 0; i < out.size(); ++i) {
    distance_m = std::find(data.flights.begin(), data.flights.end(), i) != data.flights.end() ? 0.0 : distance_m;
    out[i] = distance_m;
    distance_m += data.measured[i] * data.period_s;
  }
  return out;
}

std::vector<double> inside(const AxisData& data, const std::vector<Range>& ranges, const std::vector<double>& values) {
  std::vector<double> out;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double t_s = data.time_s(i);
    const bool asked = std::any_of(ranges.begin(), ranges.end(),
                                   [&](const Range& range) { return t_s >= range.first && t_s < range.second; });
    if (asked && data.valid[i] != 0) {
      out.push_back(values[i]);
    }
  }
  return out;
}

struct Edge {
  double at_m;
  bool above;
  double farthest_m;
};

/// Puts the distance beyond an edge in the place of the other axis' stick, so that it moves the command in proportion.
AxisData with_tether(AxisData data, const std::vector<double>& distance_m, const Edge& edge) {
  data.other.resize(distance_m.size());
  std::transform(distance_m.begin(), distance_m.end(), data.other.begin(),
                 [&](double at) { return edge.above ? std::max(0.0, at - edge.at_m) : std::min(0.0, at - edge.at_m); });
  return data;
}

/// An edge, and the likelihood ratio that a force beginning there promises.
struct ScoredEdge {
  Edge edge;
  double likelihood_ratio = 0.0;
};

/// The edge beyond which a force is likeliest. @param flown  distance_m within the ranges
/// @param pull  the fitted axis, pulled back a little beyond the edge
ScoredEdge best_edge(const AxisData& data, const std::vector<Range>& ranges, const std::vector<double>& distance_m,
                     const std::vector<double>& flown, const model::StickAxis& pull, const ScoreTest& left) {
  ScoredEdge best{};
  const double lowest_m = quantile(flown, 0.0);
  const double highest_m = quantile(flown, 1.0);
  for (const bool above : {true, false}) {
    for (int k = 0; k < kEdges; ++k) {
      const double farthest_m = above ? highest_m : lowest_m;
      const double nearest_m = above ? lowest_m : highest_m;
      const Edge edge{nearest_m + (farthest_m - nearest_m) * k / kEdges, above, farthest_m};
      const double one = left.statistic(FreeRun(with_tether(data, distance_m, edge), ranges).error(pull));
      best = one > best.likelihood_ratio ? ScoredEdge{edge, one} : best;
    }
  }
  return best;
}

}  // namespace

std::optional<AxisTether> detect_tether_force(const AxisData& data, const std::vector<Range>& ranges,
                                              const AxisFamily& family, const Fit& fit) {
  constexpr double kMin_s = 10.0;
  const FreeRun run(data, ranges);
  const std::vector<double> distance_m = distance_flown(data);
  std::vector<double> flown = inside(data, ranges, distance_m);
  if (run.seconds() < kMin_s || flown.empty()) {
    return std::nullopt;
  }
  std::vector<FreeParameter> free_parameters = free_parameters_of(family, fit);
  const WhitenedFit free = fit_whitened(run, family.model(fit), free_parameters);
  const ScoreTest left(run, free, free_parameters);
  const double gain = free.before.scale_per_count;
  const double scale = family.scale().stick / std::max(1e-9, quantile(flown, 1.0) - quantile(flown, 0.0));
  model::StickAxis pull = free.before;
  pull.cross_axis = std::copysign(0.05 * scale, -gain);
  const auto [best, statistic] = best_edge(data, ranges, distance_m, flown, pull, left);
  if (statistic < 0.5 * kThreshold) {
    return std::nullopt;
  }
  const AxisData moved = with_tether(data, distance_m, best);
  const FreeRun tied_run(moved, ranges);
  free_parameters.push_back({"rate", &model::StickAxis::cross_axis, 0.02 * scale, -100.0 * scale, 100.0 * scale});
  const WhitenedFit with = fit_whitened(tied_run, free.before, free_parameters);
  AxisTether out;
  out.rate_per_s = -with.before.cross_axis * with.before.scale_per_count;
  out.edge_m = best.at_m;
  out.above = best.above;
  out.largest = out.rate_per_s * std::abs(best.farthest_m - best.at_m);
  out.likelihood_ratio = free.score - with.score;
  out.score = with.score;
  const Rows error = run.error(free.before).array() - free.offset;
  const double rmse = error.norm() / std::sqrt(static_cast<double>(run.size()));
  return out.likelihood_ratio > kThreshold && out.rate_per_s > 0.0 && out.largest > rmse ? std::optional(out)
                                                                                         : std::nullopt;
}

Finding tether_finding(const AxisTether& tether, const std::string& response) {
  const std::string text = printed(
      "%s falls by %.2f m/s per metre of height %s %.2f m, counted from the start of each log (likelihood ratio %.0f): "
      "a force that depends on position, such as a tether, a wall or the ground",
      response.c_str(), tether.rate_per_s, tether.above ? "above" : "below", tether.edge_m, tether.likelihood_ratio);
  return {.what = "position_force", .signal = response, .text = text};
}

}  // namespace m100::lab::identify
