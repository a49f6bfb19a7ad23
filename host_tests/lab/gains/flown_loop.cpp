// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/gains/flown_loop.h"

#include <Eigen/LU>
#include <cmath>

namespace m100::lab::gains {
namespace {

constexpr double kTick_s = 0.01;
using Dense = FlownLoop::Dense;
using Column = FlownLoop::Column;
using Index = Eigen::Index;
enum Filter : Index { kP, kV, kTilt, kRate, kD, kM };

/// The observer uses at least this time constant for an axis of first order (est/filter/filter_math.h).
constexpr double kFastest_s = 0.01;
/// Ticks of a minute of flight, in which the slowest mode of the observer, the offset, has settled.
constexpr int kObserverIterations = 6000;

FlownController::Square transition_of(const FlownController& c) {
  const model::AxisStep& s = c.step;
  FlownController::Square phi = FlownController::Square::Identity();
  phi(kV, kV) = 1.0 - kTick_s * c.drag_per_s;
  phi(kV, kTilt) = 0.5 * kTick_s * c.acceleration_per_tilt_m_s2 * (1.0 + s.oo);
  phi(kV, kRate) = 0.5 * kTick_s * c.acceleration_per_tilt_m_s2 * s.o_r;
  phi(kV, kM) = 0.5 * kTick_s * c.acceleration_per_tilt_m_s2 * s.o_u;
  phi(kV, kD) = kTick_s;
  phi(kP, kV) = kTick_s;
  phi(kP, kD) = 0.5 * kTick_s * kTick_s;
  for (const Index i : {kTilt, kRate, kM}) {
    phi(kP, i) = 0.5 * kTick_s * phi(kV, i);
  }
  phi(kTilt, kTilt) = s.oo;
  phi(kTilt, kRate) = s.o_r;
  phi(kTilt, kM) = s.o_u;
  phi(kRate, kTilt) = s.ro;
  phi(kRate, kRate) = s.rr;
  phi(kRate, kM) = s.r_u + s.r_next;
  return phi;
}

/// Updates the covariance p for one scalar measurement. @returns the Kalman gain
FlownController::Six correct(FlownController::Square& p, const FlownController::Six& h, double variance) {
  const FlownController::Six ph = p * h;
  FlownController::Six gain = ph / (h.dot(ph) + variance);
  p -= gain * ph.transpose();
  p = (0.5 * (p + p.transpose())).eval();
  return gain;
}

void steady_observer(FlownController& c, const model::EstimatorNoise& noise, const LoopTiming& timing) {
  const FlownController::Square phi = transition_of(c);
  FlownController::Six process;
  process << noise.position_process_m, noise.velocity_process_m_s, noise.tilt_process_rad,
      noise.tilt_rate_process_rad_s, noise.disturbance_process_m_s2, noise.input_offset_process_rad;
  const FlownController::Square q = (process.array().square() * kTick_s).matrix().asDiagonal();
  const double pose_s = kTick_s * static_cast<double>(timing.pose_age_ticks);
  const double attitude_s = kTick_s * static_cast<double>(timing.attitude_age_ticks);
  FlownController::Six tilt = FlownController::Six::Unit(kTilt);
  tilt(kRate) = -attitude_s;
  FlownController::Six pose = FlownController::Six::Unit(kP);
  pose(kV) = -pose_s;
  pose(kD) = 0.5 * pose_s * pose_s;
  const auto square = [](double sigma) { return sigma * sigma; };
  FlownController::Square p = FlownController::Square::Identity();
  for (int i = 0; i < kObserverIterations; ++i) {
    p = phi * p * phi.transpose() + q;
    c.tilt_gain = correct(p, tilt, square(noise.attitude_sigma_rad));
    c.rate_gain = correct(p, FlownController::Six::Unit(kRate), square(noise.rate_sigma_rad_s));
    c.pose_gain = correct(p, pose, square(noise.pose_position_sigma_m));
  }
}

void take_law(FlownController& c, const mpc::GainTable<double>& table) {
  c.state_gain = Column::Zero(table.states);
  for (std::uint32_t i = 0; i < table.states; ++i) {
    c.state_gain(i) = table.state_gain.at(i * mpc::kHorizon);
  }
  const double tilt_per_disturbance = -table.tilt_sign / table.acceleration_per_tilt;
  c.previous_gain = table.filter_gain[0] * table.rate_weight;
  c.disturbance_gain =
      table.disturbance_gain[0] +
      (table.tilt_target_gain[0] + table.input_target_gain[0] / table.input_gain) * tilt_per_disturbance;
  c.offset_gain = c.previous_gain - 1.0;
}

/// Shifts a history of u, newest first, by one and inserts the newest value.
template <typename Segment>
void shift_in(Segment&& u, double newest) {
  for (Index i = u.size() - 1; i > 0; --i) {
    u(i) = u(i - 1);
  }
  if (u.size() > 0) {
    u(0) = newest;
  }
}

/// One prediction as in est::AxisFilter. @param acceleration receives the model's acceleration, without the disturbance
FlownController::Six predicted(const FlownController& c, const FlownController::Six& from, const Column& commands,
                               double& acceleration) {
  const model::AxisStep& s = c.step;
  const auto ticks = static_cast<Index>(c.delay.ticks);
  const double rest = c.delay.delay_s / kTick_s - static_cast<double>(c.delay.ticks);
  const auto mixed = [&](Index ago) { return commands(ago) + rest * (commands(ago + 1) - commands(ago)); };
  const double now = mixed(ticks);
  const double jump = now - mixed(ticks + 1);
  const double after = mixed(ticks > 0 ? ticks - 1 : 0);
  FlownController::Six to = from;
  to(kTilt) = s.oo * from(kTilt) + s.o_r * from(kRate) + s.o_u * (now + from(kM)) + s.o_jump * jump;
  to(kRate) = s.ro * from(kTilt) + s.rr * from(kRate) + s.r_u * (now + from(kM)) + s.r_next * (after + from(kM)) +
              s.r_jump * jump;
  acceleration = 0.5 * c.acceleration_per_tilt_m_s2 * (from(kTilt) + to(kTilt)) - c.drag_per_s * from(kV);
  const double total_acceleration = acceleration + from(kD);
  to(kP) += kTick_s * from(kV) + 0.5 * kTick_s * kTick_s * total_acceleration;
  to(kV) += kTick_s * total_acceleration;
  return to;
}

}  // namespace

Column step_state(const mpc::StepModel<double>& model, const Column& state, double input, double disturbance) {
  Column out(state.size());
  for (Index row = 0; row < state.size(); ++row) {
    const auto r = static_cast<std::size_t>(row);
    out(row) = model.input.at(r) * input + model.disturbance.at(r) * disturbance;
    for (Index col = 0; col < state.size(); ++col) {
      out(row) += model.transition.at(r * mpc::kMaxStates + static_cast<std::size_t>(col)) * state(col);
    }
  }
  return out;
}

FlownController::FlownController(const model::Vehicle& identified, Axis axis, const LoopTiming& timing) {
  const model::Vehicle believed = model::controller_model(identified);
  model::StickAxis attitude = attitude_of(believed, axis);
  if (attitude.is_first_order() && attitude.time_constant_s < kFastest_s) {
    attitude.time_constant_s = kFastest_s;
  }
  const mpc::GainTable<double> table = make_axis_table(believed, axis);
  step = model::axis_step(attitude, kTick_s);
  acceleration_per_tilt_m_s2 = table.tilt_sign * table.acceleration_per_tilt;
  drag_per_s = believed.translation.linear_drag_per_s;
  delay = table.delay;
  scale_per_count = attitude.scale_per_count;
  take_law(*this, table);
  steady_observer(*this, believed.estimator, timing);
}

double FlownController::stick_gain(const model::StickAxis& truth, const LoopTiming& timing) const {
  const bool stated = scale_per_count > 0.0 && truth.scale_per_count > 0.0;
  return timing.by_sticks && stated ? truth.scale_per_count / scale_per_count : 1.0;
}

Index FlownController::own_states(const LoopTiming& timing) const {
  return 6 + static_cast<Index>(timing.pose_age_ticks) + static_cast<Index>(delay.ticks) + 3 + 1;
}

double FlownController::tick(Eigen::Ref<Column> own, const Seen& seen, bool sends, const LoopTiming& timing) const {
  const auto poses = static_cast<Index>(timing.pose_age_ticks);
  const Index held = own.size() - 1;  // index of the controller's held command
  auto filter = own.head(6);
  auto accelerations = own.segment(6, poses);                  // the filter's, of the last ticks, newest first
  auto commands = own.segment(6 + poses, held - (6 + poses));  // the controller's, newest first
  shift_in(commands, own(held));
  const Six before = filter;
  double acceleration = 0.0;
  Six estimate = predicted(*this, before, commands, acceleration);
  const double turning = (estimate(kRate) - before(kRate)) / kTick_s;
  shift_in(accelerations, acceleration);
  const double old_s = kTick_s * static_cast<double>(timing.attitude_age_ticks);
  estimate += tilt_gain * (seen.tilt_rad - estimate(kTilt) + old_s * estimate(kRate) - 0.5 * old_s * old_s * turning);
  estimate += rate_gain * (seen.rate_rad_s - estimate(kRate) + old_s * turning);
  const double age_s = kTick_s * static_cast<double>(poses);
  double expected = estimate(kP) - age_s * estimate(kV) + 0.5 * age_s * age_s * estimate(kD);
  for (Index j = 0; j < poses; ++j) {
    expected += kTick_s * kTick_s * (static_cast<double>(poses - j) - 0.5) * accelerations(j);
  }
  estimate += pose_gain * (seen.position_m - expected);
  filter = estimate;
  const double commanded = law(commands, estimate);
  if (sends) {
    own(held) = commanded;
  }
  return commanded;
}

/// The present command of the law.
double FlownController::law(const Column& commands, const Six& estimate) const {
  const auto ticks = static_cast<Index>(delay.ticks);
  const double offset = estimate(kM);
  const double disturbance = estimate(kD);
  const double acting = commands(ticks) + offset;
  double chi = estimate(kTilt);
  double chi_rate = estimate(kRate);
  if (delay.lead.share != 0.0) {
    chi = (chi - delay.lead.share * acting) / (1.0 - delay.lead.share);
  } else if (delay.lead.zero_s != 0.0) {
    chi_rate = delay.lead.rate_gain * (chi_rate - delay.lead.jump * (acting - chi));
    chi -= delay.lead.zero_s * chi_rate;
  }
  Column state(state_gain.size());
  state.head(3) << estimate(kP), estimate(kV), chi;
  if (state.size() == 4) {
    state(3) = chi_rate;
  }
  state = step_state(delay.rest, state, acting, disturbance);
  for (Index ago = ticks; ago >= 1; --ago) {
    state = step_state(delay.tick, state, commands(ago - 1) + offset, disturbance);
  }
  return state_gain.dot(state) + disturbance_gain * disturbance + offset_gain * offset + previous_gain * commands(0);
}

LiftedController::LiftedController(const FlownController& controller, const LoopTiming& timing) {
  const Index n = controller.own_states(timing);
  const auto ticks = static_cast<Index>(timing.command_ticks);
  a.resize(n, n);
  b.resize(n, 3 * ticks);
  c.resize(n);
  d.resize(3 * ticks);
  for (Index i = 0; i < n + 3 * ticks; ++i) {
    Column own = i < n ? Column(Column::Unit(n, i)) : Column(Column::Zero(n));
    double commanded = 0.0;
    for (Index k = 0; k < ticks; ++k) {
      const Index input = i - n - 3 * k;
      const double out = controller.tick(own,
                                         {.position_m = input == 0 ? 1.0 : 0.0,
                                          .tilt_rad = input == 1 ? 1.0 : 0.0,
                                          .rate_rad_s = input == 2 ? 1.0 : 0.0},
                                         k == 0, timing);
      commanded = k == 0 ? out : commanded;
    }
    (i < n ? a.col(i) : b.col(i - n)) = own;
    (i < n ? c(i) : d(i - n)) = commanded;
  }
}

Eigen::RowVectorXcd LiftedController::response(std::complex<double> z) const {
  Eigen::MatrixXcd m = -a.transpose().cast<std::complex<double>>();
  m.diagonal().array() += z;
  const Eigen::VectorXcd left = m.partialPivLu().solve(c.cast<std::complex<double>>());
  return left.transpose() * b.cast<std::complex<double>>() + d.transpose().cast<std::complex<double>>();
}

/// Offsets of the parts in the state vector.
struct FlownLoop::Parts {
  Index vehicle, line, seen, positions, held, own, size;
  Parts(Index states, Index under_way, const LoopTiming& timing, Index own_states) {
    vehicle = 0;
    line = states;            // the vehicle's commands in its delay line, newest first
    seen = line + under_way;  // tilt and rate of the last ticks, newest first
    positions = seen + 2 * static_cast<Index>(timing.attitude_age_ticks);  // of the last ticks, newest first
    held = positions + static_cast<Index>(timing.pose_age_ticks);          // the command that the vehicle holds
    own = held + 1;                                                        // the controller's state
    size = own + own_states;
  }
};

FlownLoop::FlownLoop(const FlownController& controller, const model::Vehicle& truth, Axis axis,
                     const LoopTiming& timing)
    : controller_(controller), timing_(timing), period_s_(kTick_s * static_cast<double>(timing.command_ticks)) {
  const model::StickAxis& attitude = attitude_of(truth, axis);
  const ContinuousAxis continuous = continuous_axis(truth, axis);
  const double stick_gain = controller.stick_gain(attitude, timing);
  const double delay_s = attitude.transport_delay_s + timing.extra_delay_s;
  const double ticks = std::floor(delay_s / kTick_s + 1e-6);
  const Real rest_s = std::max(Real(0), Real(delay_s) - Real(ticks) * Real(kTick_s));
  const DiscreteAxis first = discretise(continuous, rest_s);
  const DiscreteAxis second = discretise(continuous, Real(kTick_s) - rest_s);
  a_ = (second.a * first.a).cast<double>();
  early_ = stick_gain * (second.a * first.b).cast<double>();
  late_ = stick_gain * second.b.cast<double>();
  line_ = static_cast<Index>(ticks) + 1;
  const Index n = a_.rows();
  tilt_ = Eigen::RowVectorXd::Zero(n);
  rate_ = Eigen::RowVectorXd::Zero(n);
  if (n == 4) {
    const double w = attitude.natural_frequency_rad_s;
    const double zero = attitude.lead_zero_s;
    tilt_(2) = 1.0;
    tilt_(3) = zero;
    rate_(2) = -zero * w * w;
    rate_(3) = 1.0 - 2.0 * attitude.damping_ratio * w * zero;
    rate_per_input_ = stick_gain * zero * w * w;
  } else {
    const double tau = attitude.time_constant_s;
    const double share = attitude.lead_zero_s / tau;
    tilt_(2) = 1.0 - share;
    tilt_per_input_ = stick_gain * share;
    rate_(2) = -(1.0 - share) / tau;
    rate_per_input_ = stick_gain * (1.0 - share) / tau;
  }
  const Parts parts(n, line_, timing, controller.own_states(timing));
  const auto period = [&](Column& state, double vehicle_input) {
    const double commanded = tick(state, parts, true, vehicle_input);
    for (std::size_t i = 1; i < timing_.command_ticks; ++i) {
      tick(state, parts, false, 0.0);
    }
    return commanded;
  };
  loop_.resize(parts.size, parts.size);
  out_.resize(parts.size);
  for (Index i = 0; i < parts.size; ++i) {
    Column unit = Column::Unit(parts.size, i);
    out_(i) = period(unit, 0.0);
    loop_.col(i) = unit;
  }
  in_ = Column::Zero(parts.size);
  period(in_, 1.0);
}

/// Simulates one tick. @returns the law's command in it
double FlownLoop::tick(Column& state, const Parts& at, bool sends, double vehicle_input) const {
  auto vehicle = state.segment(at.vehicle, at.line);
  auto line = state.segment(at.line, at.seen - at.line);
  auto seen = state.segment(at.seen, at.positions - at.seen);
  auto positions = state.segment(at.positions, at.held - at.positions);

  const double acting = line(line_ - 1);
  const double tilt = tilt_.dot(vehicle) + tilt_per_input_ * acting;
  const double rate = rate_.dot(vehicle) + rate_per_input_ * acting;
  const Index attitudes = seen.size() / 2;
  FlownController::Seen arrived{.position_m = vehicle(0), .tilt_rad = tilt, .rate_rad_s = rate};
  if (attitudes > 0) {
    arrived.tilt_rad = seen(2 * attitudes - 2);
    arrived.rate_rad_s = seen(2 * attitudes - 1);
  }
  shift_in(seen, rate);
  shift_in(seen, tilt);
  if (positions.size() > 0) {
    arrived.position_m = positions(positions.size() - 1);
  }
  shift_in(positions, vehicle(0));

  const double commanded = controller_.tick(state.tail(at.size - at.own), arrived, sends, timing_);
  if (sends) {
    state(at.held) = vehicle_input;
  }
  const double now = state(at.held);
  vehicle = (a_ * vehicle + early_ * line(line_ - 1) + late_ * (line_ > 1 ? line(line_ - 2) : now)).eval();
  shift_in(line, now);
  return commanded;
}

std::complex<double> FlownLoop::response(double frequency_rad_s) const {
  const std::complex<double> z = std::polar(1.0, frequency_rad_s * period_s_);
  Eigen::MatrixXcd m = -loop_.cast<std::complex<double>>();
  m.diagonal().array() += z;
  return out_.cast<std::complex<double>>().dot(m.partialPivLu().solve(in_.cast<std::complex<double>>()));
}

bool FlownLoop::closed_is_stable() const {
  Dense closed = loop_ + in_ * out_.transpose();
  for (int i = 0; i < 22; ++i) {  // power 2^22: two days of flight at 25 Hz
    closed = (closed * closed).eval();
    if (!(closed.cwiseAbs().maxCoeff() < 1e100)) {
      return false;
    }
  }
  return closed.cwiseAbs().maxCoeff() < 1e-3;
}

Margins flown_margins_of(const model::Vehicle& believed, const model::Vehicle& truth, Axis axis,
                         const LoopTiming& timing, int frequencies) {
  const FlownController controller(believed, axis, timing);
  const auto stable = [&](double extra_delay_s) {
    LoopTiming late = timing;
    late.extra_delay_s += extra_delay_s;
    return FlownLoop(controller, truth, axis, late).closed_is_stable();
  };
  const FlownLoop loop(controller, truth, axis, timing);
  Margins out = margins_from([&](double frequency) { return loop.response(frequency); }, loop.period_s(), frequencies);
  out.stable = loop.closed_is_stable();
  if (!out.stable) {
    out.delay_margin_s = 0.0;
    return out;
  }
  // The delay margin is searched, because a delay shorter than a command period is not a pure phase shift.
  constexpr double kStep_s = 0.01;
  double low = 0.0;
  double high = kStep_s;
  while (high < kLargestDelay_s && stable(high)) {
    low = high;
    high += kStep_s;
  }
  while (high < kLargestDelay_s && high - low > 2e-4) {
    const double middle = 0.5 * (low + high);
    (stable(middle) ? low : high) = middle;
  }
  out.delay_margin_s = low;
  return out;
}

}  // namespace m100::lab::gains
