// SPDX-License-Identifier: BSD-3-Clause
// Poses that are smooth and wrong, in flights of the whole controller against the emulated autopilot: after how long
// and how far from an honest flight the pose is refused, how far the aircraft is until the sticks are the pilot's, and
// how fast it then is (promise R14).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>

#include "firmware/mpc/generated/gain_table.h"
#include "host_tests/lab/campaign/tasks.h"
#include "host_tests/lab/experiments/flight.h"

namespace m100::scenario {
namespace {

using Place = core::Vector<double, 3>;
using Sample = sim::PoseSample;

constexpr double kStruckAt_s = 10.0;  ///< two seconds into the tasks' first step
constexpr double kFromStart = -1.0;
constexpr double kShort_s = 10.0;  ///< a flight whose pose lies from the start
constexpr int kSeeds = 4;

/// A lie changes a sample; `from` is the first one that it struck, `t_s` the time since.
struct Lie {
  const char* name;
  std::function<void(Sample& sample, const Sample& from, double t_s)> tell;
  const char* task;
  double within_s;  ///< of all seeds; infinity: it is not always noticed
  double within_m;
  double until_the_pilot_m;  ///< how far the aircraft may come before the sticks are the pilot's
  double from_s = kStruckAt_s;
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
void turns180(Sample& sample, const Sample& from, double) { about(sample, from, -1.0, 0.0, 0.0, -1.0); }
void mirrors(Sample& sample, const Sample& from, double) { about(sample, from, 1.0, 0.0, 0.0, -1.0); }
void swaps(Sample& sample, const Sample& from, double) { about(sample, from, 0.0, 1.0, 1.0, 0.0); }
void scales(Sample& sample, const Sample& from, double) { about(sample, from, 1.4, 0.0, 0.0, 1.4); }
void sinks(Sample& sample, const Sample& from, double) {
  sample.position_w_m.z() = 2.0 * from.position_w_m.z() - sample.position_w_m.z();
}

const Lie kLies[] = {
    {"standing.moving", stands, "step_3m", 3.0, 1.5, 2.5},
    {"standing.hover", stands, "hover", kNever, kNever, kNever},
    {"foreign.hover", walks, "hover", 3.0, 1.5, 2.0},
    {"foreign.moving", walks, "step_3m", 3.0, 1.5, 2.0},
    {"drift.hover", drifts, "hover", 3.0, 1.0, 2.0},
    {"rise.hover", rises, "hover", 6.0, 2.0, 3.0},
    {"turn20.hover", turns20, "hover", kNever, kNever, kNever},
    {"turn20.moving", turns20, "step_3m", kNever, kNever, kNever},
    {"turn90.hover", turns90, "hover", 3.0, 1.0, 1.5},
    {"turn90.moving", turns90, "step_3m", 3.0, 1.0, 1.5},
    {"mirror.hover", mirrors, "hover", 3.0, 1.0, 2.0},
    {"mirror.moving", mirrors, "step_3m", 3.0, 1.0, 2.0},
    {"swap.hover", swaps, "hover", 3.0, 1.0, 1.5},
    {"swap.moving", swaps, "step_3m", 3.0, 1.0, 1.5},
    {"scale.hover", scales, "hover", kNever, kNever, kNever},
    {"scale.moving", scales, "step_3m", 5.0, 1.0, 1.5},
    {"climb.hover", sinks, "hover", 3.0, 1.0, 2.0},
    {"climb.moving", sinks, "step_3m", 3.0, 1.0, 2.0},
    {"turn90.start", turns90, "hover", 3.0, 1.0, 2.0, kFromStart},
    {"turn180.start", turns180, "hover", 3.0, 1.0, 3.0, kFromStart},
    {"mirror.start", mirrors, "hover", 3.0, 1.0, 3.0, kFromStart},
    {"swap.start", swaps, "hover", 3.0, 1.0, 3.0, kFromStart},
    {"standing.start", stands, "hover", kNever, kNever, kNever, kFromStart},
    {"foreign.start", walks, "hover", kNever, kNever, kNever, kFromStart},
};
/// The aircraft is the pilot's no faster than this, m/s: the ladder hands over below 0.9 by what it knows.
constexpr double kHandOver_m_s = 1.0;

lab::experiments::FlightResult flown(const char* task_name, int seed, const Lie* lie, double from_s) {
  const lab::campaign::Task task = lab::campaign::tasks_of(task_name).front();
  lab::experiments::FlightPlan plan;
  plan.plant = sim::measured_plant();
  plan.vehicle = companion::as_file(mpc::generated::kVehicle);
  plan.course = task.course;
  plan.duration_s = from_s < 0.0 ? kShort_s : task.duration_s;
  plan.seed = static_cast<std::uint64_t>(seed);
  plan.pilot_holds_place = true;
  if (lie == nullptr) {
    return lab::experiments::fly(plan);
  }
  const auto strike = [from = std::make_shared<std::optional<Sample>>(), lie](sim::World& world) {
    world.pose_source().set_faults({.lie = [from, lie](Sample& sample) {
      if (!from->has_value()) {
        *from = sample;
      }
      lie->tell(sample, **from, core::seconds<double>(sample.captured - (*from)->captured));
    }});
  };
  if (from_s < 0.0) {
    plan.prepare = strike;
  } else {
    plan.disturb = [strike, from_s, struck = false](sim::World& world, double t_s) mutable {
      if (!struck && t_s >= from_s) {
        struck = true;
        strike(world);
      }
    };
  }
  return lab::experiments::fly(plan);
}

/// Each honest flight is flown once for all lies.
const lab::experiments::FlightResult& honestly_flown(const char* task, int seed, double from_s) {
  static std::map<std::pair<std::string, int>, lab::experiments::FlightResult> kept;
  const auto key = std::make_pair((from_s < 0.0 ? "short " : "") + std::string(task), seed);
  const auto found = kept.find(key);
  return found != kept.end() ? found->second : kept.emplace(key, flown(task, seed, nullptr, from_s)).first->second;
}

struct Noticed {
  double after_s = kNever;
  double away_m = 0.0;      ///< from where the honest flight was then, or at its end
  double farthest_m = 0.0;  ///< until the sticks were the pilot's
  double speed_m_s = 0.0;   ///< horizontal, when they were
};

Noticed noticed(const Lie& lie, int seed) {
  const lab::experiments::FlightResult& honest = honestly_flown(lie.task, seed, lie.from_s);
  const lab::experiments::FlightResult told = flown(lie.task, seed, &lie, lie.from_s);
  Noticed out;
  for (std::size_t i = 0; i < std::min(honest.trace.size(), told.trace.size()); ++i) {
    const lab::experiments::TracePoint& point = told.trace[i];
    const auto& a = honest.trace[i].position_m;
    const auto& b = point.position_m;
    if (out.after_s != kNever && point.rung == static_cast<int>(safety::Rung::kSilent)) {
      break;
    }
    const double away_m = std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
    out.farthest_m = std::max(out.farthest_m, away_m);
    out.speed_m_s = std::hypot(point.velocity_m_s[0], point.velocity_m_s[1]);
    if (out.after_s == kNever) {
      out.away_m = away_m;
      if (point.rung != static_cast<int>(safety::Rung::kNominal)) {
        out.after_s = point.t_s - std::max(lie.from_s, 0.0);
      }
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
    if (found.after_s != kNever) {
      worst.farthest_m = std::max(worst.farthest_m, found.farthest_m);
      worst.speed_m_s = std::max(worst.speed_m_s, found.speed_m_s);
    }
    EXPECT_LE(found.after_s, lie.within_s) << "seed " << seed;
    EXPECT_LE(found.away_m, lie.within_m) << "seed " << seed;
    EXPECT_LE(found.farthest_m, lie.until_the_pilot_m) << "seed " << seed;
    if (lie.within_s != kNever) {
      EXPECT_LT(found.speed_m_s, kHandOver_m_s) << "seed " << seed;
    }
  }
  char text[96];
  static_cast<void>(std::snprintf(text, sizeof text, "%d of %d | %.1f s | %.2f m | %.2f m | %.2f m/s", kSeeds - missed,
                                  kSeeds, worst.after_s, worst.away_m, worst.farthest_m, worst.speed_m_s));
  RecordProperty("figure.lie." + std::string(lie.name), text);
  std::printf("%s | %s\n", lie.name, text);
}
INSTANTIATE_TEST_SUITE_P(Lies, SmoothLie, ::testing::ValuesIn(kLies), [](const auto& tested) {
  std::string name = tested.param.name;
  std::replace(name.begin(), name.end(), '.', '_');
  return name;
});

/// A lie of any size, and the sizes between which the smallest one is searched that is noticed with every seed.
struct SizedLie {
  const char* name;
  const char* unit;
  const char* task;
  double small;
  double large;
  std::function<void(Sample& sample, const Sample& from, double t_s, double size)> tell;
};

void turned_by(Sample& sample, const Sample& from, double degrees) {
  const double c = std::cos(degrees * std::numbers::pi / 180.0), s = std::sin(degrees * std::numbers::pi / 180.0);
  about(sample, from, c, -s, s, c);
}

const SizedLie kSizedLies[] = {
    {"drift", "m/s", "hover", 0.02, 2.0,
     [](Sample& s, const Sample&, double t, double v) { s.position_w_m.x() += v * t; }},
    {"rise", "m/s", "hover", 0.02, 2.0,
     [](Sample& s, const Sample&, double t, double v) { s.position_w_m.z() += v * t; }},
    {"jump", "m", "hover", 0.005, 2.0, [](Sample& s, const Sample&, double, double d) { s.position_w_m.x() += d; }},
    {"walk", "m", "hover", 0.02, 1.0,
     [](Sample& s, const Sample& from, double t, double d) {
       stands(s, from, t);
       s.position_w_m += d * Place(0.5 - 0.5 * std::cos(t), 0.5 * std::sin(t) * (1.0 - std::exp(-t)), 0.0);
     }},
    {"heading", "deg", "hover", 1.0, 90.0,
     [](Sample& s, const Sample&, double, double degrees) { s.yaw_rad += degrees * std::numbers::pi / 180.0; }},
    {"turn", "deg", "step_3m", 2.0, 90.0,
     [](Sample& s, const Sample& from, double, double degrees) { turned_by(s, from, degrees); }},
    {"turn_hover", "deg", "hover", 2.0, 120.0,
     [](Sample& s, const Sample& from, double, double degrees) { turned_by(s, from, degrees); }},
    {"scale", "%", "step_3m", 2.0, 200.0,
     [](Sample& s, const Sample& from, double, double percent) {
       about(s, from, 1.0 + 0.01 * percent, 0.0, 0.0, 1.0 + 0.01 * percent);
     }},
};

class SmallestLie : public ::testing::TestWithParam<SizedLie> {};

TEST_P(SmallestLie, ThatIsNoticedWithEverySeed) {
  RecordProperty("promise", "R14");
  const SizedLie& sized = GetParam();
  const auto worst_of = [&](double size) {
    const Lie lie{.name = sized.name,
                  .tell = [&](Sample& s, const Sample& from, double t_s) { sized.tell(s, from, t_s, size); },
                  .task = sized.task,
                  .within_s = kNever,
                  .within_m = kNever,
                  .until_the_pilot_m = kNever};
    Noticed worst{.after_s = 0.0};
    for (int seed = 1; seed <= kSeeds && worst.after_s != kNever; ++seed) {
      const Noticed found = noticed(lie, seed);
      worst.after_s = std::max(worst.after_s, found.after_s);
      worst.away_m = std::max(worst.away_m, found.away_m);
      worst.farthest_m = std::max(worst.farthest_m, found.farthest_m);
    }
    return worst;
  };
  double unseen = sized.small, seen = sized.large;
  Noticed worst = worst_of(seen);
  ASSERT_LT(worst.after_s, kNever) << "not even the largest one";
  for (int halving = 0; halving < 7; ++halving) {
    const double middle = std::sqrt(unseen * seen);
    const Noticed found = worst_of(middle);
    (found.after_s == kNever ? unseen : seen) = middle;
    worst = found.after_s == kNever ? worst : found;
  }
  char text[96];
  static_cast<void>(std::snprintf(text, sizeof text, "%.2g %s | %.1f s | %.2f m | %.2f m", seen, sized.unit,
                                  worst.after_s, worst.away_m, worst.farthest_m));
  RecordProperty("figure.smallest." + std::string(sized.name), text);
  std::printf("smallest %s | %s\n", sized.name, text);
}
INSTANTIATE_TEST_SUITE_P(Lies, SmallestLie, ::testing::ValuesIn(kSizedLies),
                         [](const auto& tested) { return std::string(tested.param.name); });

}  // namespace
}  // namespace m100::scenario
