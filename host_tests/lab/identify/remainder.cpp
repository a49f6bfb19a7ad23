// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/identify/remainder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "host_tests/lab/identify/output/spectra.h"
#include "host_tests/lab/identify/remainder_channels.h"
#include "host_tests/lab/identify/residual_tests/predictable_share.h"
#include "host_tests/lab/printed.h"
#include "host_tests/lab/statistics.h"

namespace m100::lab::identify {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;
using Values = std::vector<double>;

constexpr std::size_t kHalfWindow = 3;     // of the seven rows of a parabola
constexpr std::size_t kBumps = 8;          // cubic B-splines between the ends of a channel: five pieces
constexpr std::size_t kUnseenPieces = 10;  // of the log, which outlast the memory of air; two are left out at a time
constexpr std::size_t kChanceShifts = 19;  // the best of them is exceeded by chance once in 20 times
constexpr std::size_t kDrawnCurves = 6;    // curves with points
constexpr std::size_t kMinRemainderRows = 50;  // 10 s
constexpr double kMinStep_s = 0.2;             // between rows of a regression: their windows of 0.35 s overlap by half
constexpr double kMaxRemainderRows = 3000.0;   // ten minutes: more would only cost time
constexpr double kCorrelated_s = 2.5;          // for the bands, rows within this time may be correlated
constexpr std::array kRidgePenalties{0.02, 0.2, 2.0};

/// Value, slope and curvature at each row of the least-squares parabola through the seven rows about it.
struct Parabolas {
  Values value, slope, curvature;
};

/// Near the ends of a segment the first or last parabola is repeated. Precondition: segments of seven rows or more.
Parabolas parabolas(const Values& rows, const std::vector<std::pair<std::size_t, std::size_t>>& segments,
                    double row_s) {
  constexpr double kN = 7.0, kS2 = 28.0, kS4 = 196.0;  // sums of k^0, k^2 and k^4 for k from -3 to 3
  Parabolas out{Values(rows.size()), Values(rows.size()), Values(rows.size())};
  for (const auto& [first, last] : segments) {
    for (std::size_t i = first; i < last; ++i) {
      const std::size_t centre = std::clamp(i, first + kHalfWindow, last - 1 - kHalfWindow);
      double sum = 0.0, odd = 0.0, even = 0.0;
      for (std::size_t at = centre - kHalfWindow; at <= centre + kHalfWindow; ++at) {
        const double k = static_cast<double>(at) - static_cast<double>(centre);
        sum += rows[at];
        odd += k * rows[at];
        even += k * k * rows[at];
      }
      out.value[i] = (kS4 * sum - kS2 * even) / (kN * kS4 - kS2 * kS2);
      out.slope[i] = odd / kS2 / row_s;
      out.curvature[i] = 2.0 * (kN * even - kS2 * sum) / (kN * kS4 - kS2 * kS2) / (row_s * row_s);
    }
  }
  return out;
}

/// Columns of a regression spline: the value itself and uniform cubic B-splines (Eilers and Marx, Statist. Sci. 11,
/// 1996).
class Basis {
 public:
  static constexpr std::size_t kColumns = kBumps + 1;

  explicit Basis(const Values& values) : low_(quantile(values, 0.02)), high_(quantile(values, 0.98)) {}
  bool is_empty() const { return !(high_ > low_); }
  double low() const { return low_; }
  double high() const { return high_; }
  /// The columns at x; beyond the ends the value of the end.
  Vector operator()(double x) const {
    const double share = (std::clamp(x, low_, high_) - low_) / (high_ - low_);
    Vector out(static_cast<Eigen::Index>(kColumns));
    out(0) = share;
    for (std::size_t k = 0; k < kBumps; ++k) {
      const double far = std::abs(share * static_cast<double>(kBumps - 3) + 1.0 - static_cast<double>(k));
      const double beyond = std::max(0.0, 2.0 - far);
      out(static_cast<Eigen::Index>(k) + 1) =
          far < 1.0 ? 2.0 / 3.0 - far * far + 0.5 * far * far * far : beyond * beyond * beyond / 6.0;
    }
    return out;
  }

 private:
  double low_, high_;
};

/// The remainder of one input, and its regressions.
class Remainder {
 public:
  Remainder(const RemainderInput& input, const logs::FlightLog& log) : input_(input) {
    segments_ = stretches(input.t_s, input.row_s);
    std::erase_if(segments_, [](const auto& one) { return one.second - one.first <= 2 * kHalfWindow; });
    const auto inverse = [&](const Parabolas& of) {
      Values out(of.value.size());
      for (std::size_t i = 0; i < out.size(); ++i) {
        out[i] = of.value[i] + input.slope_s * of.slope[i] + input.curvature_s2 * of.curvature[i];
      }
      return out;
    };
    const Parabolas model = parabolas(input.model, segments_, input.row_s);
    command_ = inverse(model);
    choose_rows();
    target_ = chosen(inverse(parabolas(input.error, segments_, input.row_s)));
    channels_ = channels_of(log, input);
    if (!input.response.empty()) {
      channels_.push_back({input.response + " of the model", "", model.value});
      channels_.push_back({"rate of " + input.response + " of the model", "", model.slope});
    }
    for (std::size_t k = 0; k < channels_.size(); ++k) {
      if (channels_[k].name == input.stick) {
        channels_.push_back(
            {"rate of " + input.stick, "per s", parabolas(channels_[k].values, segments_, input.row_s).slope});
        break;
      }
    }
  }

  /// All curves without points.
  std::vector<RemainderCurve> shares() const {
    std::vector<RemainderCurve> out;
    for (const Channel& channel :
         static_cast<Eigen::Index>(kMinRemainderRows) > target_.size() ? std::vector<Channel>{} : channels_) {
      const Basis basis(channel.values);
      for (const bool is_gain : basis.is_empty() ? std::vector<bool>{} : std::vector<bool>{false, true}) {
        const std::vector<RegressorGroup> groups = penalised(channel, basis, is_gain);
        const ResidualFinding::Share best = predictable_shares({target_}, groups, rows_, kChanceShifts).front();
        out.push_back({.channel = channel.name,
                       .unit = channel.unit,
                       .direction = input_.direction,
                       .is_gain = is_gain,
                       .predicted = best.predicted,
                       .chance = best.shifted});
      }
    }
    return out;
  }

  /// Draws the curve. With `subtract` it is then taken from the remainder.
  void draw(RemainderCurve& curve, bool subtract) {
    const Channel& channel = channel_of(curve);
    const Basis basis(channel.values);
    const std::vector<RegressorGroup> groups = penalised(channel, basis, curve.is_gain);
    const std::string ridge = predictable_shares({target_}, groups, rows_, 0).front().source;
    const auto best = std::ranges::find(groups, ridge, &RegressorGroup::source);
    const Vector left = fit(*best, basis, curve);
    add_means(channel, curve);
    target_ = subtract ? left : target_;
  }

  /// The share of what is left that the curve's channel predicts.
  double share_of(const RemainderCurve& curve) const {
    const Channel& channel = channel_of(curve);
    return predictable_shares({target_}, penalised(channel, Basis(channel.values), curve.is_gain), rows_, 0)
        .front()
        .predicted;
  }

  const std::string& direction() const { return input_.direction; }

 private:
  const Channel& channel_of(const RemainderCurve& curve) const {
    return *std::ranges::find(channels_, curve.channel, &Channel::name);
  }

  /// Rows of the regression, in ten pieces for cross-validation.
  void choose_rows() {
    const auto stride = static_cast<std::size_t>(std::ceil(
        std::max(kMinStep_s / input_.row_s - 1e-9, static_cast<double>(input_.t_s.size()) / kMaxRemainderRows)));
    for (const auto& [first, last] : segments_) {
      for (std::size_t i = first + kHalfWindow; i + kHalfWindow < last; i += stride) {
        rows_.begin.push_back(i);
        rows_.end.push_back(i + 1);
        const bool goes_on = !block_.empty() && i > first + kHalfWindow && input_.t_s[i] - block_t_s_ < kCorrelated_s;
        block_t_s_ = goes_on ? block_t_s_ : input_.t_s[i];
        block_.push_back(block_.empty() ? 0 : block_.back() + (goes_on ? 0 : 1));
      }
    }
    for (std::size_t row = 0; row < rows_.begin.size(); ++row) {
      rows_.fold.push_back(row * kUnseenPieces / rows_.begin.size() % kResidualFolds);
    }
  }

  Vector chosen(const Values& values) const {
    Vector out(static_cast<Eigen::Index>(rows_.begin.size()));
    for (std::size_t row = 0; row < rows_.begin.size(); ++row) {
      out(static_cast<Eigen::Index>(row)) = values[rows_.begin[row]];
    }
    return out;
  }

  /// The spline's columns, smoothed as the remainder is, once for each penalty.
  std::vector<RegressorGroup> penalised(const Channel& channel, const Basis& basis, bool is_gain) const {
    std::vector<Values> all(Basis::kColumns, Values(channel.values.size()));
    for (std::size_t i = 0; i < channel.values.size(); ++i) {
      const Vector at = basis(channel.values[i]) * (is_gain ? command_[i] : 1.0);
      for (std::size_t k = 0; k < all.size(); ++k) {
        all[k][i] = at(static_cast<Eigen::Index>(k));
      }
    }
    RegressorGroup group;
    for (const Values& column : all) {
      const Vector smooth = chosen(parabolas(column, segments_, input_.row_s).value);
      group.columns.emplace_back(smooth.begin(), smooth.end());
    }
    std::vector<RegressorGroup> out;
    for (const double ridge : kRidgePenalties) {
      group.ridge = ridge;
      group.source = std::to_string(ridge);
      out.push_back(group);
    }
    return out;
  }

  /// Fits all rows and fills the curve and its band: the covariance of a sum over blocks, within which rows may be
  /// correlated in any way (Liang and Zeger, Biometrika 73, 1986). @returns what the curve leaves.
  Vector fit(const RegressorGroup& group, const Basis& basis, RemainderCurve& curve) const {
    const Eigen::Index rows = target_.size();
    const auto columns = static_cast<Eigen::Index>(Basis::kColumns);
    Matrix x(rows, columns);
    Vector mean(columns), size(columns);
    for (Eigen::Index k = 0; k < columns; ++k) {
      const Vector column = Eigen::Map<const Vector>(group.columns[static_cast<std::size_t>(k)].data(), rows);
      mean(k) = column.mean();
      size(k) = std::max(1e-300, std::sqrt((column.array() - mean(k)).square().mean()));
      x.col(k) = (column.array() - mean(k)) / size(k);
    }
    Matrix normal = x.transpose() * x;
    normal.diagonal().array() += group.ridge * static_cast<double>(rows);
    const Eigen::LDLT<Matrix> solver(normal);
    const Vector about = target_.array() - target_.mean();
    const Vector weights = solver.solve(x.transpose() * about);
    Vector left = about - x * weights;
    Matrix scores = Matrix::Zero(static_cast<Eigen::Index>(block_.back()) + 1, columns);
    for (Eigen::Index row = 0; row < rows; ++row) {
      scores.row(static_cast<Eigen::Index>(block_[static_cast<std::size_t>(row)])) += left(row) * x.row(row);
    }
    const Matrix covariance = solver.solve(solver.solve(scores.transpose() * scores).transpose());
    constexpr int kPoints = 41;
    for (int point = 0; point < kPoints; ++point) {
      const double at = basis.low() + (basis.high() - basis.low()) * point / (kPoints - 1);
      const Vector here = ((basis(at) - (curve.is_gain ? Vector(Vector::Zero(columns)) : mean)).array() / size.array());
      const double value = here.dot(weights);
      const double half = 1.96 * std::sqrt(std::max(0.0, here.dot(covariance * here)));
      curve.x.push_back(at);
      curve.value.push_back(value);
      curve.low.push_back(value - half);
      curve.high.push_back(value + half);
    }
    return left;
  }

  /// Means of the remainder, or of the gain's change, over groups of rows with neighbouring values of the channel.
  void add_means(const Channel& channel, RemainderCurve& curve) const {
    constexpr std::size_t kGroups = 30;
    const Vector x = chosen(channel.values);
    const Vector command = chosen(command_);
    const auto rows = static_cast<std::size_t>(x.size());
    std::vector<Eigen::Index> order(rows);
    std::iota(order.begin(), order.end(), 0);
    std::ranges::sort(order, {}, [&](Eigen::Index row) { return x(row); });
    const double mean = curve.is_gain ? 0.0 : target_.mean();
    for (std::size_t group = 0; group < kGroups; ++group) {
      double at = 0.0, product = 0.0, power = 0.0;
      const std::size_t first = group * rows / kGroups;
      const std::size_t last = (group + 1) * rows / kGroups;
      for (std::size_t k = first; k < last; ++k) {
        const double partner = curve.is_gain ? command(order[k]) : 1.0;
        at += x(order[k]) / static_cast<double>(last - first);
        product += (target_(order[k]) - mean) * partner;
        power += partner * partner;
      }
      curve.mean_x.push_back(at);
      curve.mean.push_back(power > 0.0 ? product / power : std::nan(""));
    }
  }

  const RemainderInput& input_;
  std::vector<std::pair<std::size_t, std::size_t>> segments_;
  Values command_;
  std::vector<Channel> channels_;
  Thinned rows_;
  std::vector<std::size_t> block_;  ///< of each row of rows_
  double block_t_s_ = 0.0;
  Vector target_;
};

RemainderInput input_of(const AxisProblem& problem, const Fit& fit) {
  static constexpr std::array<std::array<const char*, 2>, 4> kRates{
      {{"roll", "rate_x"}, {"pitch", "rate_y"}, {"yaw_rate", "rate_z"}, {"climb", "velocity_z"}}};
  const FreeRun run = problem.free_run();
  const AxisData& data = run.data();
  const model::StickAxis model = problem.axis_family().model(fit);
  RemainderInput out{.row_s = run.mean_s(), .t_s = run.time_s()};
  const Rows error = run.error(model);
  for (std::size_t row = 0; row < run.size(); ++row) {
    const double first_s = out.t_s[row] - 0.5 * (run.mean_s() - data.period_s);
    const auto first = static_cast<std::size_t>(std::lround((first_s - data.start_s) / data.period_s));
    double measured = 0.0;
    for (std::size_t i = first; i < first + run.mean(); ++i) {
      measured += data.measured[i] / static_cast<double>(run.mean());
    }
    const double wrong = error(static_cast<Eigen::Index>(row));
    out.error.push_back(-wrong);
    out.model.push_back(measured + wrong);
  }
  const double f = model.natural_frequency_rad_s;
  out.slope_s = model.is_first_order() ? model.time_constant_s : 2.0 * model.damping_ratio / f;
  out.curvature_s2 = model.is_first_order() ? 0.0 : 1.0 / (f * f);
  out.stick_delay_s = model.transport_delay_s;
  out.stick = problem.stick_name();
  out.response = problem.training().signals.response_name;
  for (const auto& [axis, rate] : kRates) {
    out.rate = axis == problem.request().axis ? rate : out.rate;
  }
  return out;
}

}  // namespace

std::vector<RemainderInput> remainder_of(const IdentifyResult& translation) {
  const Figures& figures = translation.figures;
  std::vector<RemainderInput> out;
  for (const std::string direction : {"x", "y", "z"}) {
    RemainderInput one{.direction = direction, .row_s = figures.sample_period_s, .t_s = figures.t_s};
    for (const Series& series : figures.series) {
      if (series.name == "final_residual_" + direction) {
        one.error = series.values;
      } else if (series.name == "input_" + direction) {
        one.model = series.values;
      }
    }
    if (one.error.size() == one.t_s.size() && !one.error.empty()) {
      out.push_back(std::move(one));
    }
  }
  return out;
}

std::vector<RemainderCurve> remainder_curves(const std::vector<RemainderInput>& inputs, const logs::FlightLog& log) {
  std::vector<Remainder> remainders;
  std::vector<RemainderCurve> out;
  double chance = 0.0;
  for (const RemainderInput& input : inputs) {
    remainders.emplace_back(input, log);
    for (RemainderCurve& curve : remainders.back().shares()) {
      chance = std::max(chance, curve.chance);
      out.push_back(std::move(curve));
    }
  }
  std::ranges::stable_sort(out, std::greater<>{}, &RemainderCurve::predicted);
  const auto of = [&](const RemainderCurve& curve) -> Remainder& {
    return *std::ranges::find_if(remainders, [&](const auto& one) { return one.direction() == curve.direction; });
  };
  for (std::size_t k = std::min(out.size(), kDrawnCurves); k-- > 0;) {  // the first last: it is subtracted
    of(out[k]).draw(out[k], k == 0);
  }
  for (RemainderCurve& curve : out) {
    curve.chance = chance;
    curve.after_first = curve.x.empty() || &curve == &out.front() ? 0.0 : of(curve).share_of(curve);
  }
  return out;
}

void draw_remainder(const AxisProblem& problem, const Fit& fit, const logs::FlightLog& log, SideFindings& out) {
  constexpr double kCertain = 0.25;  // as of bursts and of a spectral peak; of 56 healthy logs one reaches 0.18
  const RemainderInput input = input_of(problem, fit);
  out.remainder = remainder_curves({input}, log);
  const auto own = std::ranges::find_if(out.remainder, [&](const RemainderCurve& curve) {
    return curve.channel.ends_with(input.stick) || curve.channel.ends_with(input.response + " of the model");
  });
  if (own != out.remainder.end() && own->predicted > std::max(kCertain, ResidualOptions{}.shift_factor * own->chance +
                                                                            ResidualOptions{}.shift_margin)) {
    out.unexplained.push_back(printed(
        "the remainder follows %s (%.0f %% of it in pieces that the curve has not seen; chance reaches %.0f %%)",
        own->channel.c_str(), 100.0 * own->predicted, 100.0 * own->chance));
  }
}

}  // namespace m100::lab::identify
