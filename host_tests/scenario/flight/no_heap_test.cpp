// SPDX-License-Identifier: BSD-3-Clause
// R1 on the host: the count of allocations must not change during a tick, from start-up through flight to release.
#include <gtest/gtest.h>
#include <cstdlib>
#include <memory>
#include <new>
#include <vector>

#include "firmware/app/flight_controller.h"
#include "firmware/companion/files/course/course.h"
#include "firmware/core/eigen.h"
#include "firmware/mpc/generated/gain_table.h"
#include "host_tests/lab/gains/gain_tables.h"
#include "host_tests/sim/ports/world.h"

namespace {
std::size_t allocations = 0;
}  // namespace

// Deviation: this program replaces the allocator on purpose. The library's operator new calls malloc, and so does
// Eigen. The sanitizers have their own allocator: with them, only operator new is counted.
#ifdef M100_SANITIZED
void* operator new(std::size_t size) {
  ++allocations;
  if (void* const memory = std::malloc(size); memory != nullptr) {
    return memory;
  }
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
#else
extern "C" {
void* __libc_malloc(std::size_t size);                     // NOLINT: the name is the C library's
void* __libc_calloc(std::size_t count, std::size_t size);  // NOLINT
void* __libc_realloc(void* memory, std::size_t size);      // NOLINT
void* malloc(std::size_t size) {
  ++allocations;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  ++allocations;
  return __libc_calloc(count, size);
}
void* realloc(void* memory, std::size_t size) {
  ++allocations;
  return __libc_realloc(memory, size);
}
}
#endif

namespace m100::app {
namespace {

// Checks the counter itself: one that counts nothing would pass every test.
TEST(NoHeap, IsCounted) {
  std::size_t before = allocations;
  const auto by_new = std::make_unique<std::vector<int>>(1000);
  EXPECT_GE(allocations - before, 2U);
#ifndef M100_SANITIZED
  before = allocations;
  Eigen::MatrixXd by_eigen(30, 30);
  by_eigen.setZero();
  EXPECT_GE(allocations - before, 1U) << by_eigen(0, 0);
#endif
}

TEST(NoHeap, IsTouchedInAnyTick) {
  RecordProperty("promise", "R1");
  sim::World world(sim::measured_plant(), {.seed = 1});
  const auto tables = lab::gains::make_gain_tables(mpc::generated::kVehicle, mpc::generated::kVehicleDigest);
  ref::Trajectory<double> course;
  ref::Waypoint<double> start;
  start.position_w_m = world.vehicle().state().position_w_m;
  companion::parse_course("step 0.5 0 0.2 0.3 2\nsquare 1 2 0.2\n", start, course);
  std::vector<std::byte> storage(1U << 18U);
  log::Ring ring(storage);
  log::FlightLogWriter log(ring);
  ASSERT_EQ(log.begin(core::TimePoint{}, {}), core::Status::kOk);
  const auto controller = std::make_unique<FlightController<double>>(
      mpc::generated::kVehicle, tables, kDefaultFlight, world.autopilot_uart(), world.pose_uart(), course, &log);
  std::size_t in_ticks = 0;
  bool flew = false;
  for (int i = 0; i < 2500; ++i) {
    world.advance(core::kTickPeriod);
    if (i == 300) {
      controller->engage();
    }
    if (i == 2000) {
      controller->release();
    }
    const std::size_t before = allocations;
    static_cast<void>(controller->tick(world.now()));
    in_ticks += allocations - before;
    flew = flew || controller->grant().failsafe_state == safety::FailsafeState::kNominal;
    ring.drain([](std::span<const std::byte>) {});
  }
  EXPECT_TRUE(flew);
  EXPECT_EQ(in_ticks, 0U);
}

}  // namespace
}  // namespace m100::app
