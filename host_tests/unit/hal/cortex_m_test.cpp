// SPDX-License-Identifier: BSD-3-Clause
// The register code of the Cortex-M machine runs on structs of registers; the tests call the interrupt handlers.
#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "hal/cortex_m/cmsdk_uart.h"
#include "hal/cortex_m/cmsdk_watchdog.h"
#include "hal/cortex_m/systick_clock.h"

namespace m100::hal {
namespace {

constexpr std::uint32_t kTransmitterFull = 1;
constexpr std::uint32_t kReceiverFull = 2;

struct Board {
  CmsdkUartRegisters registers{};
  volatile std::uint32_t pend = 0;
  CmsdkUart uart{registers, pend, 0x20};

  void arrive(std::uint32_t byte) {
    registers.data = byte;
    registers.state = registers.state | kReceiverFull;
    uart.on_receive();
    registers.state = registers.state & ~kReceiverFull;
  }
  /// Acts as the transmitter: takes each byte from the data register and asks for the next.
  std::vector<std::uint32_t> transmit_all() {
    std::vector<std::uint32_t> sent;
    constexpr std::uint32_t kNothing = 0xFFFFFFFF;
    for (registers.data = kNothing, uart.on_transmit(); registers.data != kNothing; uart.on_transmit()) {
      sent.push_back(static_cast<std::uint32_t>(registers.data));
      registers.data = kNothing;
    }
    return sent;
  }
};

TEST(CmsdkUart, StartsBothDirectionsWithADividerThatTheHardwareTakes) {
  Board board;
  board.uart.start(25000000, 115200);
  EXPECT_EQ(board.registers.divider, 217U);
  EXPECT_EQ(board.registers.control, 0xFU);
  board.uart.start(1000000, 115200);
  EXPECT_EQ(board.registers.divider, 16U);
}

TEST(CmsdkUart, GivesWhatArrivedInOrderAndAcknowledgesFirst) {
  Board board;
  for (const std::uint32_t byte : {1U, 2U, 255U}) {
    board.arrive(byte);
    EXPECT_EQ(board.registers.interrupt, 2U);
  }
  std::array<std::byte, 8> bytes{};
  ASSERT_EQ(board.uart.read(bytes).value(), 3U);
  EXPECT_EQ(bytes[2], std::byte{255});
  EXPECT_EQ(board.uart.read(bytes).value(), 0U);
}

// Would catch: a handler that reads a byte at every interrupt.
TEST(CmsdkUart, ReadsNothingWhenTheReceiverIsEmpty) {
  Board board;
  board.uart.on_receive();
  EXPECT_EQ(board.uart.received(), 0U);
}

TEST(CmsdkUart, CountsWhatDoesNotFit) {
  Board board;
  for (std::size_t i = 0; i < CmsdkUart::kReceiveBytes + 5; ++i) {
    board.arrive(static_cast<std::uint32_t>(i & 0xFFU));
  }
  EXPECT_EQ(board.uart.lost(), 5U);
  EXPECT_EQ(board.uart.received(), CmsdkUart::kReceiveBytes + 5);
}

// Overruns of the data register and of the ring both count, and the overrun flag of the register is cleared.
TEST(CmsdkUart, CountsOverrunsOfTheRegisterAndOfTheRing) {
  Board board;
  constexpr std::uint32_t kReceiverOverran = 8;
  board.registers.state = kReceiverOverran;
  board.arrive(7);
  EXPECT_EQ(board.uart.line_errors().value(), (LineErrors{.framing = 0, .parity = 0, .overrun = 1, .breaks = 0}));
  EXPECT_EQ(board.uart.received(), 1U) << "the byte that is there is good";
  board.registers.state = 0;
  for (std::size_t i = 0; i < CmsdkUart::kReceiveBytes + 1; ++i) {
    board.arrive(1);
  }
  EXPECT_EQ(board.uart.line_errors().value().overrun, 1U + 2U);
}

// The flag is cleared by writing its bit. No other bit may be written, because the others belong to the device.
TEST(CmsdkUart, ClearsTheOverrunFlagAlone) {
  Board board;
  board.registers.state = 8U | kReceiverFull | kTransmitterFull;
  board.uart.on_receive();
  EXPECT_EQ(board.registers.state, 8U);
}

TEST(CmsdkUart, SendsFromTheInterruptThatAWritePends) {
  Board board;
  const std::array<std::byte, 3> bytes{std::byte{7}, std::byte{8}, std::byte{9}};
  ASSERT_EQ(board.uart.write(bytes).value(), 3U);
  EXPECT_EQ(board.pend, 0x20U);
  EXPECT_EQ(board.transmit_all(), (std::vector<std::uint32_t>{7, 8, 9}));
}

TEST(CmsdkUart, WaitsForAFullTransmitter) {
  Board board;
  const std::array<std::byte, 1> bytes{std::byte{7}};
  ASSERT_EQ(board.uart.write(bytes).value(), 1U);
  board.registers.state = kTransmitterFull;
  board.registers.data = 0;
  board.uart.on_transmit();
  EXPECT_EQ(board.registers.data, 0U);
  board.registers.state = 0;
  EXPECT_EQ(board.transmit_all(), std::vector<std::uint32_t>{7});
}

TEST(CmsdkUart, TakesNoMoreThanItsRingHolds) {
  Board board;
  const std::vector<std::byte> bytes(CmsdkUart::kTransmitBytes + 10);
  EXPECT_EQ(board.uart.write(bytes).value(), CmsdkUart::kTransmitBytes);
  EXPECT_EQ(board.uart.accepted(), CmsdkUart::kTransmitBytes);
}

// The last bytes of a failing program: waiting bytes leave first, and a dead line must not block the program for ever.
TEST(CmsdkUart, WritesWithoutInterruptsAndGivesUpOnADeadLine) {
  Board board;
  const std::array<std::byte, 2> bytes{std::byte{1}, std::byte{2}};
  ASSERT_EQ(board.uart.write(bytes).value(), 2U);
  const std::array<std::byte, 1> last{std::byte{3}};
  board.uart.write_without_interrupts(last);
  EXPECT_EQ(board.registers.data, 3U);
  EXPECT_TRUE(board.transmit_all().empty());
  board.registers.state = kTransmitterFull;
  board.uart.write_without_interrupts(bytes);
  EXPECT_NE(board.registers.data, 2U);
}

// A stray write cannot stop a locked watchdog, so it must be locked again after each access.
TEST(CmsdkWatchdog, CountsThePatienceInterruptsThenResetsAndLocksItself) {
  CmsdkWatchdogRegisters registers{};
  volatile std::uint32_t lock = 1;
  CmsdkWatchdog watchdog(registers, lock, 25000000);
  watchdog.start(std::chrono::milliseconds(500));
  EXPECT_EQ(registers.load, 12500000U);
  EXPECT_EQ(registers.control, 3U);
  EXPECT_EQ(lock, 0U);
  registers.interrupt_clear = 0;
  lock = 1;
  watchdog.feed();
  EXPECT_NE(registers.interrupt_clear, 0U);
  EXPECT_EQ(lock, 0U);
}

TEST(SysTickClock, CountsPeriodsAndReadsTheRest) {
  SysTickRegisters registers{};
  SysTickClock clock(registers, 25000000, 10000);
  clock.start();
  EXPECT_EQ(registers.reload, 249999U);
  EXPECT_EQ(registers.control, 7U);
  EXPECT_EQ(clock.cycles(), 0U);
  registers.value = 249999;
  EXPECT_EQ(clock.cycles(), 1U);
  registers.value = 125000;
  EXPECT_EQ(clock.now(), core::TimePoint(std::chrono::milliseconds(5)));
  clock.on_period();
  registers.value = 0;  // the interrupt comes with the step to 0
  EXPECT_EQ(clock.now(), core::TimePoint(std::chrono::milliseconds(10)));
}

}  // namespace
}  // namespace m100::hal
