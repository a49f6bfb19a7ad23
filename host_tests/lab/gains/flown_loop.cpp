// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/lab/gains/flown_loop.h"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace m100::lab::gains {
namespace {

constexpr double kTick_s = 0.01;
using Column = Eigen::VectorXd;
using Index = Eigen::Index;
enum Filter : Index { kP, kV, kTilt, kRate, kD, kM };

/// The observer uses at least this time constant for an axis of first order (est/filter/response_step.h).
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

void set_steady_observer(FlownController& c, const model::EstimatorNoise& noise) {
  const FlownController::Square phi = transition_of(c);
  FlownController::Six process;
  process << noise.position_process_m, noise.velocity_process_m_s, noise.tilt_process_rad,
      noise.tilt_rate_process_rad_s, noise.disturbance_process_m_s2, noise.input_offset_process_rad;
  const FlownController::Square q = (process.array().square() * kTick_s).matrix().asDiagonal();
  const double pose_s = kTick_s * static_cast<double>(c.timing.pose_age_ticks);
  const double attitude_s = kTick_s * static_cast<double>(c.timing.attitude_age_ticks);
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

void set_law(FlownController& c, const mpc::GainTable<double>& table) {
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

/// The state after one step of the predictor's model.
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

}  // namespace

FlownController::FlownController(const model::Vehicle& identified, Axis axis, const LoopTiming& assumed)
    : timing(assumed) {
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
  set_law(*this, table);
  set_steady_observer(*this, believed.estimator);
  const Index own = 6 + static_cast<Index>(timing.pose_age_ticks) + static_cast<Index>(delay.ticks) + 4;
  const auto ticks = static_cast<Index>(timing.command_ticks);
  lifted.emplace(own, 3 * ticks, 1, [&](Column& state, const Column& in, Column& out) {
    for (Index k = 0; k < ticks; ++k) {
      const double commanded = tick(state, in.segment<3>(3 * k), k == 0);
      out(0) = k == 0 ? commanded : out(0);
    }
  });
}

double FlownController::stick_gain(const model::StickAxis& truth) const {
  const bool stated = scale_per_count > 0.0 && truth.scale_per_count > 0.0;
  return timing.by_sticks && stated ? truth.scale_per_count / scale_per_count : 1.0;
}

/// One tick of observer, prediction and law. @param own  the filter, its last accelerations, the last commands, the
/// command that holds  @param seen  position, tilt and rate that arrive  @returns the command of the law
double FlownController::tick(Column& own, const Eigen::Vector3d& seen, bool sends) const {
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
  estimate += tilt_gain * (seen(1) - estimate(kTilt) + old_s * estimate(kRate) - 0.5 * old_s * old_s * turning);
  estimate += rate_gain * (seen(2) - estimate(kRate) + old_s * turning);
  const double age_s = kTick_s * static_cast<double>(poses);
  double expected = estimate(kP) - age_s * estimate(kV) + 0.5 * age_s * age_s * estimate(kD);
  for (Index j = 0; j < poses; ++j) {
    expected += kTick_s * kTick_s * (static_cast<double>(poses - j) - 0.5) * accelerations(j);
  }
  estimate += pose_gain * (seen(0) - expected);
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

LiftedSystem::LiftedSystem(Index states, Index inputs, Index outputs, const Period& period)
    : a(states, states), b(states, inputs), c(outputs, states), d(outputs, inputs) {
  for (Index i = 0; i < states + inputs; ++i) {
    Column state = i < states ? Column(Column::Unit(states, i)) : Column(Column::Zero(states));
    Column out = Column::Zero(outputs);
    period(state, i < states ? Column(Column::Zero(inputs)) : Column(Column::Unit(inputs, i - states)), out);
    (i < states ? a.col(i) : b.col(i - states)) = state;
    (i < states ? c.col(i) : d.col(i - states)) = out;
  }
  const Eigen::ComplexSchur<Eigen::MatrixXd> schur(a);
  schur_ = schur.matrixT();
  into_ = schur.matrixU().adjoint() * b;
  out_of_ = c * schur.matrixU();
}

Eigen::MatrixXcd LiftedSystem::response(std::complex<double> z) const {
  Eigen::MatrixXcd m = -schur_;
  m.diagonal().array() += z;
  const auto triangle = m.triangularView<Eigen::Upper>();
  if (c.rows() < b.cols()) {
    return triangle.solve<Eigen::OnTheRight>(out_of_) * into_ + d;
  }
  return out_of_ * triangle.solve(into_) + d;
}

namespace {

/// One horizontal axis from tick to tick: x(k+1) = a x + early u(k-n-1) + late u(k-n) with a delay of n ticks and a
/// part of one; tilt and rate as its attitude sensor sees them.
struct Aircraft {
  Aircraft(const model::Vehicle& truth, Axis axis, double extra_delay_s);

  Eigen::MatrixXd a;
  Column early, late;
  Eigen::RowVectorXd tilt, rate;
  double tilt_per_input = 0.0, rate_per_input = 0.0;
  Index line = 1;  ///< commands under way, n + 1
};

Aircraft::Aircraft(const model::Vehicle& truth, Axis axis, double extra_delay_s) {
  const model::StickAxis& attitude = attitude_of(truth, axis);
  const ContinuousAxis continuous = continuous_axis(truth, axis);
  const double delay_s = attitude.transport_delay_s + extra_delay_s;
  const double ticks = std::floor(delay_s / kTick_s + 1e-6);
  const Real rest_s = std::max(Real(0), Real(delay_s) - Real(ticks) * Real(kTick_s));
  const DiscreteAxis first = discretise(continuous, rest_s);
  const DiscreteAxis second = discretise(continuous, Real(kTick_s) - rest_s);
  a = (second.a * first.a).cast<double>();
  early = (second.a * first.b).cast<double>();
  late = second.b.cast<double>();
  line = static_cast<Index>(ticks) + 1;
  tilt = rate = Eigen::RowVectorXd::Zero(a.rows());
  const double zero = attitude.lead_zero_s;
  if (!attitude.is_first_order()) {
    const double w = attitude.natural_frequency_rad_s;
    tilt(2) = 1.0;
    tilt(3) = zero;
    rate(2) = -zero * w * w;
    rate(3) = 1.0 - 2.0 * attitude.damping_ratio * w * zero;
    rate_per_input = zero * w * w;
  } else {
    const double tau = attitude.time_constant_s;
    tilt_per_input = zero / tau;
    tilt(2) = 1.0 - tilt_per_input;
    rate(2) = -tilt(2) / tau;
    rate_per_input = tilt(2) / tau;
  }
}

/// A measurement as old as its sensor makes it. @param past  of the last ticks, newest first
template <typename Segment>
double delayed(Segment&& past, double newest) {
  const double arrives = past.size() > 0 ? past(past.size() - 1) : newest;
  shift_in(past, newest);
  return arrives;
}

}  // namespace

LiftedSystem lifted_aircraft(const model::Vehicle& truth, Axis axis, const LoopTiming& timing) {
  const Aircraft of(truth, axis, timing.extra_delay_s);
  const auto ticks = static_cast<Index>(timing.command_ticks);
  const auto old = static_cast<Index>(timing.attitude_age_ticks), pose = static_cast<Index>(timing.pose_age_ticks);
  const Index n = of.a.rows(), line_end = n + of.line, pose_end = line_end + 2 * old + pose;
  // The state: the vehicle; its commands under way, newest first; the last tilts, rates and positions.
  return {pose_end, 1, 3 * ticks, [&](Column& state, const Column& in, Column& out) {
            for (Index k = 0; k < ticks; ++k) {
              const Column vehicle = state.head(n);
              auto line = state.segment(n, of.line);
              const double acting = line(of.line - 1);
              out(3 * k) = delayed(state.segment(line_end + 2 * old, pose), vehicle(0));
              out(3 * k + 1) = delayed(state.segment(line_end, old), of.tilt.dot(vehicle) + of.tilt_per_input * acting);
              out(3 * k + 2) =
                  delayed(state.segment(line_end + old, old), of.rate.dot(vehicle) + of.rate_per_input * acting);
              shift_in(line, in(0));
              state.head(n) = of.a * vehicle + of.early * acting + of.late * line(of.line - 1);
            }
          }};
}

FlownLoop::FlownLoop(const FlownController& controller, const model::Vehicle& truth, Axis axis,
                     const LoopTiming& timing)
    : controller_(*controller.lifted),
      aircraft_(lifted_aircraft(truth, axis, timing)),
      stick_gain_(controller.stick_gain(attitude_of(truth, axis))),
      period_s_(kTick_s * static_cast<double>(timing.command_ticks)) {}

std::complex<double> FlownLoop::response(double frequency_rad_s) const {
  const std::complex<double> z = std::polar(1.0, frequency_rad_s * period_s_);
  return stick_gain_ * (controller_.response(z) * aircraft_.response(z)).value();
}

bool FlownLoop::closed_is_stable() const {
  const LiftedSystem &law = controller_, &air = aircraft_;
  // The command leaves in the first tick, before any measurement that it changes: law.d * air.d is 0.
  const Eigen::MatrixXd from_air = stick_gain_ * law.d * air.c, from_law = stick_gain_ * law.c;
  const Index n = air.a.rows(), all = n + law.a.rows();
  Eigen::MatrixXd closed(all, all);
  closed << air.a + air.b * from_air, air.b * from_law, law.b * (air.c + air.d * from_air),
      law.a + law.b * air.d * from_law;
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
  constexpr int kSteps = 40;
  int steps = 0;
  while (steps < kSteps && stable(kLargestDelay_s * (steps + 1) / kSteps)) {
    ++steps;
  }
  double low = kLargestDelay_s * steps / kSteps;
  double high = kLargestDelay_s * (steps + 1) / kSteps;
  while (steps < kSteps && high - low > 2e-4) {
    const double middle = 0.5 * (low + high);
    (stable(middle) ? low : high) = middle;
  }
  out.delay_margin_s = low;
  return out;
}

}  // namespace m100::lab::gains
