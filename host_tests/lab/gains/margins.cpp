// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/gains/margins.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

#include "host_tests/lab/gains/flown_loop.h"

namespace m100::lab::gains {
namespace {

constexpr double kTick_s = 0.01;
using Dense = Eigen::MatrixXd;
using Column = Eigen::VectorXd;
using Complex = std::complex<double>;

/// One axis from tick to tick, including its delay line: x(k+1) = a x + early u(k-n-1) + late u(k-n) + bd d.
struct SampledAxis {
  Dense a;
  Column early;
  Column late;
  Column bd;
  std::size_t ticks = 0;
};
SampledAxis sampled(const model::Vehicle& vehicle, Axis axis) {
  const ContinuousAxis continuous = continuous_axis(vehicle, axis);
  const mpc::DelayModel<double> delay = make_delay_model(vehicle, axis);
  const Real rest_s = std::max(Real(0), Real(delay.delay_s) - Real(delay.ticks) * Real(kTick_s));
  const DiscreteAxis first = discretise(continuous, rest_s);
  const DiscreteAxis second = discretise(continuous, Real(kTick_s) - rest_s);
  const DiscreteAxis all = discretise(continuous, Real(kTick_s));
  return {.a = all.a.cast<double>(),
          .early = (second.a * first.b).cast<double>(),
          .late = second.b.cast<double>(),
          .bd = all.bd.cast<double>(),
          .ticks = delay.ticks};
}

/// The filter with its steady gain. Its states are those of the axis, the disturbance and the input offset.
struct Observer {
  Dense a;       ///< of the whole state over a tick
  Column early;  ///< input of the axis
  Column late;
  Dense c;
  Dense gain;
};
Observer observer(const model::Vehicle& vehicle, Axis axis, std::size_t pose_age_ticks) {
  const SampledAxis plant = sampled(vehicle, axis);
  const model::EstimatorNoise& noise = vehicle.estimator;
  const double zero = attitude_of(vehicle, axis).lead_zero_s;
  const Eigen::Index n = plant.a.rows();
  Observer out;
  out.a = Dense::Identity(n + 2, n + 2);
  out.a.topLeftCorner(n, n) = plant.a;
  out.a.block(0, n, n, 1) = plant.bd;
  out.a.block(0, n + 1, n, 1) = plant.early + plant.late;
  out.early = Column::Zero(n + 2);
  out.late = Column::Zero(n + 2);
  out.early.head(n) = plant.early;
  out.late.head(n) = plant.late;
  const bool rate_seen = n == 4 && zero == 0.0;
  out.c = Dense::Zero(rate_seen ? 3 : 2, n + 2);
  const double age_s = static_cast<double>(pose_age_ticks) * kTick_s;
  out.c(0, 0) = 1.0;  // the position at the pose's capture: est/filter/acceleration_history.h
  out.c(0, 1) = -age_s;
  out.c(0, n) = 0.5 * age_s * age_s;
  out.c(1, 2) = 1.0;
  if (n == 4) {
    out.c(1, 3) = zero;
  }
  Column sigma(out.c.rows());
  sigma.head(2) << noise.pose_position_sigma_m, noise.attitude_sigma_rad;
  if (rate_seen) {
    out.c(2, 3) = 1.0;
    sigma(2) = noise.rate_sigma_rad_s;
  }
  Column process(n + 2);
  process.head(3) << noise.position_process_m, noise.velocity_process_m_s, noise.tilt_process_rad;
  if (n == 4) {
    process(3) = noise.tilt_rate_process_rad_s;
  }
  process.tail(2) << noise.disturbance_process_m_s2, noise.input_offset_process_rad;
  const Dense q = process.array().square().matrix().asDiagonal() * Dense::Identity(n + 2, n + 2) * kTick_s;
  const Dense r = sigma.array().square().matrix().asDiagonal() * Dense::Identity(sigma.size(), sigma.size());
  Dense p = Dense::Identity(n + 2, n + 2);
  for (int i = 0; i < 6000; ++i) {  // a minute, in which the slowest mode, the offset, has settled
    p = out.a * p * out.a.transpose() + q;
    const Dense s = out.c * p * out.c.transpose() + r;
    out.gain = solve(s.cast<Real>(), (out.c * p).cast<Real>()).cast<double>().transpose();
    p = p - out.gain * out.c * p;
    p = (0.5 * (p + p.transpose())).eval();
  }
  return out;
}

/// Linear gains of u_0 of the unconstrained law, for a reference of zero.
struct FirstInput {
  Column state;  ///< gain on the predicted states
  double disturbance = 0.0;
  double offset = 0.0;
  double previous = 0.0;
};
FirstInput first_input(const mpc::GainTable<double>& table) {
  FirstInput out;
  out.state = Column::Zero(table.states);
  for (std::uint32_t i = 0; i < table.states; ++i) {
    out.state(i) = table.state_gain.at(i * mpc::kHorizon);
  }
  const double tilt_per_disturbance = -table.tilt_sign / table.acceleration_per_tilt;
  out.previous = table.filter_gain[0] * table.rate_weight;
  out.disturbance = table.disturbance_gain[0] +
                    (table.tilt_target_gain[0] + table.input_target_gain[0] / table.input_gain) * tilt_per_disturbance;
  out.offset = out.previous - 1.0;
  return out;
}

/// The open loop as one linear system. Input: the vehicle's command; output: the controller's command.
class OpenLoop {
 public:
  OpenLoop(const model::Vehicle& believed, const model::Vehicle& truth, Axis axis, std::size_t pose_age_ticks)
      : plant_(sampled(truth, axis)),
        observer_(observer(believed, axis, pose_age_ticks)),
        table_(make_gain_tables(believed)),
        law_(first_input(axis == Axis::kX ? table_.x : table_.y)),
        delay_(make_delay_model(believed, axis)),
        truth_states_(plant_.a.rows()),
        truth_zero_s_(attitude_of(truth, axis).lead_zero_s),
        states_(static_cast<Eigen::Index>(delay_.ticks) + 1),
        age_(static_cast<Eigen::Index>(pose_age_ticks)) {
    const Eigen::Index size =
        truth_states_ + static_cast<Eigen::Index>(plant_.ticks) + 1 + observer_.a.rows() + states_ + 2 * age_;
    a_.resize(size, size);
    c_.resize(size);
    for (Eigen::Index i = 0; i < size; ++i) {
      Column unit = Column::Unit(size, i);
      c_(i) = step(unit, 0.0);
      a_.col(i) = unit;
    }
    b_ = Column::Zero(size);
    d_ = step(b_, 1.0);
  }

  /// Frequency response from the vehicle's command to the controller's, at z = exp(i w T).
  Complex response(double frequency_rad_s) const {
    const Complex z = std::polar(1.0, frequency_rad_s * kTick_s);
    Eigen::MatrixXcd m = -a_.cast<Complex>();
    m.diagonal().array() += z;
    return c_.cast<Complex>().dot(m.partialPivLu().solve(b_.cast<Complex>())) + d_;
  }
  bool closed_is_stable() const {
    Dense closed = a_ + b_ * c_.transpose() / (1.0 - d_);
    for (int i = 0; i < 24; ++i) {  // the power 2^24 of a tick: two days of flight
      closed = (closed * closed).eval();
      if (!(closed.cwiseAbs().maxCoeff() < 1e100)) {
        return false;
      }
    }
    return closed.cwiseAbs().maxCoeff() < 1e-3;
  }

 private:
  /// Simulates one tick. @returns the controller's command. State: vehicle, its last inputs, filter as predicted for
  /// this tick, controller's last commands, the vehicle's last positions, the filter's last accelerations; all newest
  /// first.
  double step(Column& state, double vehicle_input) const {
    const Eigen::Index line = static_cast<Eigen::Index>(plant_.ticks) + 1;
    const Eigen::Index full = observer_.a.rows();
    auto vehicle = state.head(truth_states_);
    auto line_inputs = state.segment(truth_states_, line);
    auto filter = state.segment(truth_states_ + line, full);
    auto sent = state.segment(truth_states_ + line + full, states_);
    auto positions = state.segment(truth_states_ + line + full + states_, age_);
    auto accelerations = state.tail(age_);

    // The filter is corrected first; its step to the next tick is made below, where the new command is known.
    Column seen = measured(vehicle);
    if (age_ > 0) {
      seen(0) = positions(age_ - 1);
      for (Eigen::Index j = 0; j < age_; ++j) {
        seen(0) -= kTick_s * kTick_s * (static_cast<double>(age_ - j) - 0.5) * accelerations(j);
      }
    }
    Column estimate = filter;
    estimate += observer_.gain * (seen - observer_.c * estimate);
    Column predicted = estimate.head(full - 2);
    const double disturbance = estimate(full - 2);
    const double offset = estimate(full - 1);
    predicted = step_state(delay_.rest, predicted, sent(states_ - 1) + offset, disturbance);
    for (Eigen::Index ago = states_ - 2; ago >= 0; --ago) {
      predicted = step_state(delay_.tick, predicted, sent(ago) + offset, disturbance);
    }
    const double commanded =
        law_.state.dot(predicted) + law_.disturbance * disturbance + law_.offset * offset + law_.previous * sent(0);

    const Column vehicle_next = plant_.a * vehicle + plant_.early * line_inputs(line - 1) +
                                plant_.late * (line > 1 ? line_inputs(line - 2) : vehicle_input);
    const double late = states_ > 1 ? sent(states_ - 2) : commanded;
    const Column filter_next = observer_.a * estimate + observer_.early * sent(states_ - 1) + observer_.late * late;
    for (Eigen::Index i = line - 1; i > 0; --i) {
      line_inputs(i) = line_inputs(i - 1);
    }
    line_inputs(0) = vehicle_input;
    for (Eigen::Index i = states_ - 1; i > 0; --i) {
      sent(i) = sent(i - 1);
    }
    sent(0) = commanded;
    for (Eigen::Index i = age_ - 1; i >= 0; --i) {
      positions(i) = i > 0 ? positions(i - 1) : vehicle(0);
      accelerations(i) = i > 0 ? accelerations(i - 1)
                               : (filter_next(1) - estimate(1) - observer_.a(1, full - 2) * disturbance) / kTick_s;
    }
    vehicle = vehicle_next;
    filter = filter_next;
    return commanded;
  }
  Column measured(const Column& vehicle) const {
    Column out(observer_.c.rows());
    out.head(2) << vehicle(0), vehicle.size() == 4 ? vehicle(2) + truth_zero_s_ * vehicle(3) : vehicle(2);
    if (out.size() == 3) {
      out(2) = vehicle.size() == 4 ? vehicle(3) : 0.0;
    }
    return out;
  }

  SampledAxis plant_;
  Observer observer_;
  mpc::GainTables<double> table_;
  FirstInput law_;
  mpc::DelayModel<double> delay_;
  Eigen::Index truth_states_;
  double truth_zero_s_;  ///< second order: the attitude sensor measures chi + zero chi' (axis_model.h)
  Eigen::Index states_;
  Eigen::Index age_;  ///< of the pose, ticks
  Dense a_;
  Column b_;
  Column c_;
  double d_ = 0.0;
};

}  // namespace

Margins margins_from(const std::function<std::complex<double>(double)>& response, double period_s, int frequencies) {
  Margins out;
  out.gain_margin = std::numeric_limits<double>::infinity();
  out.phase_margin_rad = std::numbers::pi;
  out.delay_margin_s = std::numeric_limits<double>::infinity();
  const double low = std::log(0.02);
  const double high = std::log(std::numbers::pi / period_s);
  Complex before;
  double before_frequency = 0.0;
  double angle = 0.0;  // of 1 + L; it begins at minus a right angle for each pole at 0
  for (int i = 0; i <= frequencies; ++i) {
    const double frequency = std::exp(low + (high - low) * i / frequencies);
    const Complex gain = -response(frequency);  // L: the loop is closed by -1
    out.peak_sensitivity = std::max(out.peak_sensitivity, 1.0 / std::abs(1.0 + gain));
    angle += i > 0 ? std::arg((1.0 + gain) / (1.0 + before)) : std::arg(-1.0 - gain) - std::numbers::pi;
    if (i > 0 && (std::abs(before) - 1.0) * (std::abs(gain) - 1.0) <= 0.0) {
      // phase above -180 degrees, in [0, 2 pi): the lag that a delay must reach
      const double at = frequency * (std::abs(before) > 1.0 ? std::sqrt(before_frequency / frequency) : 1.0);
      double phase = std::arg(-gain);
      out.phase_margin_rad = std::min(out.phase_margin_rad, std::abs(phase));
      phase = phase < 0.0 ? phase + 2.0 * std::numbers::pi : phase;
      out.delay_margin_s = std::min(out.delay_margin_s, phase / at);
      out.crossover_rad_s = at;
    }
    if (i > 0 && before.imag() * gain.imag() <= 0.0 && gain.real() < 0.0 && std::abs(gain) < 1.0) {
      out.gain_margin = std::min(out.gain_margin, 1.0 / std::abs(gain));
    }
    before = gain;
    before_frequency = frequency;
  }
  out.stable = std::abs(angle) < 0.5 * std::numbers::pi;
  return out;
}

Margins margins_of(const model::Vehicle& believed, const model::Vehicle& truth, Axis axis, std::size_t pose_age_ticks) {
  const OpenLoop loop(model::controller_model(believed), truth, axis, pose_age_ticks);
  Margins out = margins_from([&](double frequency) { return loop.response(frequency); }, kTick_s);
  out.stable = loop.closed_is_stable();
  return out;
}

}  // namespace m100::lab::gains
