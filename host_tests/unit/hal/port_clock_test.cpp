// SPDX-License-Identifier: BSD-3-Clause
// A simulated port whose host is missing or has ended. unit.lockstep tests one with a host.
#include <gtest/gtest.h>

#include <cerrno>
#include <string>

#include "hal/linux/monotonic_clock.h"
#include "hal/linux/simulated_port.h"

namespace m100::hal {
namespace {

using std::chrono::milliseconds;

TEST(PortClock, GoesOnAtTheMachinesPaceWhereThereIsNoHost) {
  MonotonicClock machine;
  PortClock clock("sim:/nowhere/at/all");
  EXPECT_TRUE(clock.is_simulated());
  const core::TimePoint began = machine.now();
  const core::TimePoint first = clock.now();
  clock.sleep_until(first + milliseconds(40));
  EXPECT_EQ(clock.now(), first + milliseconds(40)) << "to the microsecond, however late the machine wakes up";
  EXPECT_GE(machine.now() - began, milliseconds(40));
  clock.sleep_until(first + milliseconds(1040));  // exactly a second
  EXPECT_EQ(clock.now(), first + milliseconds(1040));
  EXPECT_GE(machine.now() - began, milliseconds(1040));
  clock.sleep_until(first + milliseconds(1040));
  clock.sleep_until(first);
  EXPECT_EQ(clock.now(), first + milliseconds(1040)) << "and never back";
}

TEST(PortClock, OfARealPortIsTheMachines) {
  PortClock clock("/dev/null");
  EXPECT_FALSE(clock.is_simulated());
  const core::TimePoint began = clock.now();
  clock.sleep_until(began + milliseconds(20));
  EXPECT_GE(clock.now(), began + milliseconds(20));
}

TEST(SimulatedPort, IsNamedByItsWordAndSaysWhyItIsNotThere) {
  EXPECT_TRUE(is_simulated("sim:/tmp/a"));
  EXPECT_FALSE(is_simulated("/tmp/sim:a"));
  EXPECT_FALSE(is_simulated("sim"));
  EXPECT_FALSE(is_simulated("SIM:/tmp/a"));
  const auto why = [](const std::string& port) {
    errno = 0;
    EXPECT_EQ(open_simulated(port, 230400), -1);
    return errno;
  };
  EXPECT_EQ(why("sim:/nowhere/at/all"), ENOENT);
  EXPECT_EQ(why("sim:"), ENAMETOOLONG);
  EXPECT_EQ(why("sim:/" + std::string(106, 'a')), ENOENT) << "107 bytes and a zero find room";
  EXPECT_EQ(why("sim:/" + std::string(107, 'a')), ENAMETOOLONG);
}

}  // namespace
}  // namespace m100::hal
