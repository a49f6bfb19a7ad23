// SPDX-License-Identifier: BSD-3-Clause
// Runs one part of a tick many times, so that callgrind can count it (command and numbers: firmware/RESULTS.md):
//   valgrind --tool=callgrind --toggle-collect='*one_tick*' tick_cost axis|ekf|law|window|sticks double|float|fixed
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>

#include "firmware/ctl/law/flight_law.h"
#include "firmware/est/filter/disturbance_ekf.h"
#include "firmware/mpc/generated/gain_table.h"
#include "firmware/ref/trajectory.h"
#include "firmware/vrc/command_map.h"
#include "host_tests/property/est/long_run.h"

namespace {

using namespace m100;  // NOLINT: a program of one file

constexpr int kTicks = 1000;

model::Vehicle vehicle() {
  model::Vehicle v;
  for (model::StickAxis* axis : {&v.roll, &v.pitch}) {
    axis->natural_frequency_rad_s = 9.36;
    axis->damping_ratio = 0.68;
    axis->transport_delay_s = 0.033;
  }
  v.climb.time_constant_s = 0.334;
  v.climb.scale_per_count = 2.65e-3;
  v.yaw_rate.scale_per_count = 2.24e-3;
  return v;
}

template <typename Work>
[[gnu::noinline, gnu::noclone]] void one_tick(Work& work, int tick) {
  work(tick);
}

template <typename Work>
int repeat(Work work) {
  for (int tick = 0; tick < kTicks; ++tick) {
    one_tick(work, tick);
  }
  return 0;
}

template <typename S>
int axis() {
  est::detail::Runner<S> runner(est::measured_axis());
  return repeat(
      [&](int i) { runner.tick(0.01, 0.01, 0.01, true, 0.001 * (i % 7), 0.02, 0.001 * (i % 5), 0.01 * (i % 3)); });
}

template <typename Real>
est::Measurement<Real> measurement(int i) {
  est::Measurement<Real> m;
  m.pose.is_new = m.attitude.is_new = true;
  m.pose.set_captured_at(m.now - std::chrono::milliseconds(20));
  m.pose.position_w_m = {Real(0.001) * Real(i % 7), Real(0.001) * Real(i % 3), Real(1)};
  m.attitude.pitch_rad = Real(0.001) * Real(i % 5);
  return m;
}

template <typename S, typename Real>
int ekf() {
  est::DisturbanceEkf<S, Real> filter(vehicle());
  return repeat([&](int i) { filter.update(measurement<Real>(i), {}, core::kTickPeriod); });
}

template <typename Real>
int law() {
  const mpc::GainTables<Real> tables{.x = mpc::generated::kX<Real>, .y = mpc::generated::kY<Real>};
  ctl::FlightLaw<Real> flight_law(mpc::generated::kVehicle, tables);
  ref::Window<Real> window;
  for (std::size_t k = 0; k < window.x.size(); ++k) {
    window.x[k].position_m = Real(0.01) * static_cast<Real>(k);
  }
  window.height.position_m = Real(1);
  est::Estimate<Real> estimate;
  ctl::Command<Real> command;
  return repeat([&](int i) {
    estimate.x.position_m = Real(0.001) * Real(i % 7);
    command = flight_law.update(estimate, window, command, core::kTickPeriod);
  });
}

template <typename Real>
int window() {
  ref::Trajectory<Real> course;
  course.hold({});
  for (int i = 0; i < 20; ++i) {
    ref::Waypoint<Real> place;
    place.position_w_m = {Real(i % 2), Real(i % 3), Real(1)};
    if (course.append_quintic(place, std::chrono::milliseconds(700)) != core::Status::kOk) {
      return 1;
    }
  }
  Real sum{};
  repeat([&](int i) {
    sum += course.window(core::TimePoint(std::chrono::milliseconds(10 * i)), std::chrono::milliseconds(33))
               .x[7]
               .position_m;
  });
  return std::isfinite(sum) ? 0 : 1;
}

int sticks() {
  vrc::CommandMap map(vehicle());
  int sum = 0;
  repeat(
      [&](int i) { sum += static_cast<int>(map.to_sticks({.roll_rad = 0.001F * static_cast<float>(i % 9)})->roll); });
  return sum == 0 ? 1 : 0;
}

}  // namespace

int main(int count, char** words) {
  const char* part = count > 1 ? words[1] : "";
  const char* scalar = count > 2 ? words[2] : "float";
  struct Row {
    const char* part;
    const char* scalar;
    int (*cost)();
  };
  constexpr std::array kRows{Row{"axis", "double", &axis<double>},
                             Row{"axis", "fixed", &axis<core::Fixed>},
                             Row{"axis", "", &axis<float>},
                             Row{"ekf", "double", &ekf<double, double>},
                             Row{"ekf", "fixed", &ekf<core::Fixed, float>},
                             Row{"ekf", "", &ekf<float, float>},
                             Row{"law", "double", &law<double>},
                             Row{"law", "", &law<float>},
                             Row{"window", "double", &window<double>},
                             Row{"window", "", &window<float>},
                             Row{"sticks", "", &sticks}};
  for (const Row& row : kRows) {  // a row without a scalar matches all other scalars
    if (std::strcmp(row.part, part) == 0 && (row.scalar[0] == '\0' || std::strcmp(row.scalar, scalar) == 0)) {
      return row.cost();
    }
  }
  std::fprintf(stderr, "usage: tick_cost axis|ekf|law|window|sticks double|float|fixed\n");
  return 2;
}
