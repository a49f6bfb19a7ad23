// SPDX-License-Identifier: BSD-3-Clause
// Poses that are smooth and wrong, in flights of the whole controller against the emulated autopilot: after how long
// and how far from an honest flight the pose is refused (promise R14), and that nothing is said where nothing is wrong
// (R17).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>

#include "firmware/mpc/generated/gain_table.h"
#include "host_tests/lab/campaign/tasks.h"
#include "host_tests/lab/experiments/flight.h"

namespace m100::scenario {
namespace {

using Place = core::Vector<double, 3>;
using Sample = sim::PoseSample;

constexpr double kStruckAt_s = 10.0;  ///< two seconds into the tasks' first step
constexpr int kSeeds = 4;

/// A lie changes a sample; `from` is the first one that it struck, `t_s` the time since.
struct Lie {
  const char* name;
  void (*tell)(Sample& sample, const Sample& from, double t_s);
  const char* task;
  double within_s;  ///< of all seeds; infinity: it is not always noticed
  double within_m;
};

constexpr double kNever = std::numeric_limits<double>::infinity();

void about(Sample& sample, const Sample& from, double xx, double xy, double yx, double yy) {
  const Place d = sample.position_w_m - from.position_w_m;
  sample.position_w_m.x() = from.position_w_m.x() + xx * d.x() + xy * d.y();
  sample.position_w_m.y() = from.position_w_m.y() + yx * d.x() + yy * d.y();
}

/// Noise of a millimetre from the sample's own digits, so that no two poses are the same bits.
void stands(Sample& sample, const Sample& from, double) {
  const Place d = 1e5 * (sample.position_w_m - from.position_w_m);
  sample.position_w_m = from.position_w_m + 1e-3 * Place(std::sin(d.x()), std::sin(d.y()), std::sin(d.z()));
  sample.yaw_rad = from.yaw_rad + 2e-3 * std::sin(d.x() + d.y());
}
void walks(Sample& sample, const Sample& from, double t_s) {
  sample.position_w_m =
      from.position_w_m + Place(0.5 - 0.5 * std::cos(t_s), 0.3 * std::sin(t_s) * (1.0 - std::exp(-t_s)),
                                1e-3 * std::sin(1e5 * sample.position_w_m.z()));
}
void drifts(Sample& sample, const Sample&, double t_s) { sample.position_w_m.x() += 0.3 * t_s; }
void rises(Sample& sample, const Sample&, double t_s) { sample.position_w_m.z() += 0.3 * t_s; }
void turns20(Sample& sample, const Sample& from, double) { about(sample, from, 0.9397, -0.3420, 0.3420, 0.9397); }
void turns90(Sample& sample, const Sample& from, double) { about(sample, from, 0.0, -1.0, 1.0, 0.0); }
void mirrors(Sample& sample, const Sample& from, double) { about(sample, from, 1.0, 0.0, 0.0, -1.0); }
void swaps(Sample& sample, const Sample& from, double) { about(sample, from, 0.0, 1.0, 1.0, 0.0); }
void scales(Sample& sample, const Sample& from, double) { about(sample, from, 1.4, 0.0, 0.0, 1.4); }
void sinks(Sample& sample, const Sample& from, double) {
  sample.position_w_m.z() = 2.0 * from.position_w_m.z() - sample.position_w_m.z();
}

const Lie kLies[] = {
    {"standing.moving", stands, "step_3m", 3.0, 1.5},   {"standing.hover", stands, "hover", kNever, kNever},
    {"foreign.hover", walks, "hover", 3.0, 1.5},        {"foreign.moving", walks, "step_3m", 3.0, 1.5},
    {"drift.hover", drifts, "hover", kNever, kNever},   {"rise.hover", rises, "hover", 6.0, 2.0},
    {"turn20.hover", turns20, "hover", kNever, kNever}, {"turn20.moving", turns20, "step_3m", kNever, kNever},
    {"turn90.hover", turns90, "hover", 3.0, 1.0},       {"turn90.moving", turns90, "step_3m", 3.0, 1.0},
    {"mirror.hover", mirrors, "hover", 3.0, 1.0},       {"mirror.moving", mirrors, "step_3m", 3.0, 1.0},
    {"swap.hover", swaps, "hover", 3.0, 1.0},           {"swap.moving", swaps, "step_3m", 3.0, 1.0},
    {"scale.hover", scales, "hover", kNever, kNever},   {"scale.moving", scales, "step_3m", kNever, kNever},
    {"climb.hover", sinks, "hover", 3.0, 1.0},          {"climb.moving", sinks, "step_3m", 3.0, 1.0},
};

lab::experiments::FlightResult flown(const char* task_name, int seed, const Lie* lie) {
  const lab::campaign::Task task = lab::campaign::tasks_of(task_name).front();
  lab::experiments::FlightPlan plan;
  plan.plant = sim::measured_plant();
  plan.vehicle = companion::as_file(mpc::generated::kVehicle);
  plan.course = task.course;
  plan.duration_s = task.duration_s;
  plan.seed = static_cast<std::uint64_t>(seed);
  plan.pilot_holds_place = true;
  auto from = std::make_shared<std::optional<Sample>>();
  plan.disturb = [from, lie, struck = false](sim::World& world, double t_s) mutable {
    if (lie == nullptr || struck || t_s < kStruckAt_s) {
      return;
    }
    struck = true;
    world.pose_source().set_faults({.lie = [from, lie](Sample& sample) {
      if (!from->has_value()) {
        *from = sample;
      }
      lie->tell(sample, **from, core::seconds<double>(sample.captured - (*from)->captured));
    }});
  };
  return lab::experiments::fly(plan);
}

struct Noticed {
  double after_s = kNever;
  double away_m = 0.0;  ///< from where the honest flight was then, or at its end
};

Noticed noticed(const Lie& lie, int seed) {
  const lab::experiments::FlightResult honest = flown(lie.task, seed, nullptr);
  const lab::experiments::FlightResult told = flown(lie.task, seed, &lie);
  Noticed out;
  for (std::size_t i = 0; i < std::min(honest.trace.size(), told.trace.size()); ++i) {
    const auto& a = honest.trace[i].position_m;
    const auto& b = told.trace[i].position_m;
    out.away_m = std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
    if (told.trace[i].rung != static_cast<int>(safety::Rung::kNominal)) {
      out.after_s = told.trace[i].t_s - kStruckAt_s;
      break;
    }
  }
  return out;
}

class SmoothLie : public ::testing::TestWithParam<Lie> {};

TEST_P(SmoothLie, IsNoticedInTimeAndNearby) {
  RecordProperty("promise", "R14");
  const Lie& lie = GetParam();
  Noticed worst{.after_s = 0.0};
  int missed = 0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const Noticed found = noticed(lie, seed);
    missed += found.after_s == kNever ? 1 : 0;
    worst.after_s = found.after_s == kNever ? worst.after_s : std::max(worst.after_s, found.after_s);
    worst.away_m = std::max(worst.away_m, found.away_m);
    EXPECT_LE(found.after_s, lie.within_s) << "seed " << seed;
    EXPECT_LE(found.away_m, lie.within_m) << "seed " << seed;
  }
  char text[96];
  static_cast<void>(std::snprintf(text, sizeof text, "%d of %d | %.1f s | %.2f m", kSeeds - missed, kSeeds,
                                  worst.after_s, worst.away_m));
  RecordProperty("figure.lie." + std::string(lie.name), text);
  std::printf("%s | %s\n", lie.name, text);
}
INSTANTIATE_TEST_SUITE_P(Lies, SmoothLie, ::testing::ValuesIn(kLies), [](const auto& tested) {
  std::string name = tested.param.name;
  std::replace(name.begin(), name.end(), '.', '_');
  return name;
});

}  // namespace
}  // namespace m100::scenario
