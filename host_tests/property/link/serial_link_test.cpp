// SPDX-License-Identifier: BSD-3-Clause
// The link on a bad line, with random actions of autopilot and operator: the examiner at the other end must never find
// a violation.
#include <gtest/gtest.h>

#include "host_tests/sim/ports/link_bench.h"

namespace m100::link {
namespace {

using sim::LinkBench;
using sim::N1EventKind;
using std::chrono::milliseconds;

struct Case {
  std::uint64_t seed;
  Channel channel;
};

class CapriciousWorld : public ::testing::TestWithParam<Case> {};
std::vector<Case> cases() {
  std::vector<Case> all;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    all.push_back({seed, seed % 2 == 0 ? Channel::kVirtualRc : Channel::kMovement});
  }
  return all;
}
INSTANTIATE_TEST_SUITE_P(SerialLink, CapriciousWorld, ::testing::ValuesIn(cases()),
                         [](const auto& tested) { return "Seed" + std::to_string(tested.param.seed); });

void something(LinkBench& bench, sim::Random& random) {
  switch (random.next() % 12) {
    case 0:
      return bench.autopilot.set_mode(sim::N1Mode::kA);
    case 1:
    case 2:
      return bench.autopilot.set_mode(sim::N1Mode::kF);
    case 3:
      return bench.autopilot.happen(N1EventKind::kTake, 'm');
    case 4:
      return bench.autopilot.happen(N1EventKind::kTake, 'r');
    case 5:
      return bench.autopilot.happen(N1EventKind::kRestart);
    case 6:
      return bench.autopilot.happen(N1EventKind::kLoseAcks, 1 + static_cast<double>(random.next() % 3));
    case 7:
      return bench.autopilot.happen(N1EventKind::kDelayAcks, 0.3 * random.uniform());
    case 8:
      return bench.autopilot.happen(N1EventKind::kDoubleAcks, 3);
    case 9:
      return bench.autopilot.happen(N1EventKind::kSilence, 0.8 * random.uniform());
    case 10:
      return bench.link.release(bench.clock.now());
    default:
      return bench.link.request_control(bench.clock.now());
  }
}

TEST_P(CapriciousWorld, TheExaminerHasNothingToObject) {
  RecordProperty("promise", "R4");
  LinkBench::Options options = LinkBench::over(GetParam().channel);
  options.seed = GetParam().seed;
  LinkBench bench(options);
  sim::Random random(GetParam().seed, "capricious");
  bench.cable().b_to_a().set_faults({.drop_per_byte = 1e-4,
                                     .flip_per_bit = 1e-5,
                                     .drop_per_write = 0.01,
                                     .duplicate_per_write = 0.01,
                                     .burst_per_write = 0.005,
                                     .burst_bytes = 40});
  bench.cable().a_to_b().set_faults({.drop_per_byte = 1e-4, .flip_per_bit = 1e-5, .drop_per_write = 0.01});
  std::uint32_t times_in_control = 0;
  bool was_in_control = false;
  for (int n = 0; n < 60; ++n) {
    const bool idle = bench.link.authority().stage == safety::AuthorityStage::kReady ||
                      bench.link.authority().stage == safety::AuthorityStage::kSilent ||
                      bench.link.authority().stage == safety::AuthorityStage::kSilentCold;
    if (idle) {
      if (random.next() % 2 == 0) {  // the pilot permits it
        bench.autopilot.set_mode(sim::N1Mode::kF);
        bench.autopilot.happen(N1EventKind::kTake, 'r');
      }
      bench.link.request_control(bench.clock.now());
    }
    bench.run(milliseconds(500 + random.next() % 4000));
    const bool in_control = bench.link.authority().in_control;
    times_in_control += in_control && !was_in_control ? 1U : 0U;
    was_in_control = in_control;
    something(bench, random);
  }
  const sim::N1Record& record = bench.autopilot.record();
  EXPECT_GT(times_in_control, 0U) << "the test needs flights in control";
  // Tolerance: the autopilot stamps a frame in steps of 2.5 ms.
  EXPECT_GE(record.min_obtain_spacing.count(), 2000000 - 2500);
  EXPECT_GE(record.min_on_spacing.count(), 2000000 - 2500);
  EXPECT_LE(record.max_commands_per_s, GetParam().channel == Channel::kVirtualRc ? 25U : 50U);
  // Silence is noticed only after 500 ms; unit.serial_link checks that every other loss takes one period.
  EXPECT_LE(record.latest_after_loss, SerialLink::kLinkTimeout + bench.link.command_period());
}

}  // namespace
}  // namespace m100::link
