// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "hal/linux/serial_port.h"
#include "hal/mock/wrong_baud.h"
#include "host_tests/sim/ports/pty_uart.h"

namespace m100::sim {
namespace {

const std::string kLink =
    (std::filesystem::temp_directory_path() / ("m100_pty_" + std::to_string(::getpid()))).string();

std::vector<std::byte> text() {
  std::vector<std::byte> bytes(64);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    bytes[i] = static_cast<std::byte>(17 * i + 3);
  }
  return bytes;
}

/// The first `count` bytes. A worker of the kernel delivers what a pseudo-terminal was sent, and a port does not wait
/// for it; so reads until they are there, for a minute at the most.
std::vector<std::byte> read_bytes(hal::Uart& uart, std::size_t count) {
  std::vector<std::byte> bytes;
  for (int attempt = 0; attempt < 60000 && bytes.size() < count; ++attempt) {
    std::vector<std::byte> part(512);
    part.resize(uart.read(part).value_or(0));
    bytes.insert(bytes.end(), part.begin(), part.end());
    if (part.empty()) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
  return bytes;
}

TEST(PtyUart, AClientAtTheSameRateReadsWhatWasSent) {
  PtyUart ours(kLink, 230400);
  hal::SerialPort client(kLink, 230400);
  ASSERT_EQ(client.open(), core::Status::kOk);
  EXPECT_EQ(ours.clients_baud(), 230400U);
  EXPECT_EQ(ours.write(text()).value_or(0), text().size());
  EXPECT_EQ(read_bytes(client, text().size()), text());
  EXPECT_EQ(client.write(text()).value_or(0), text().size());
  EXPECT_EQ(read_bytes(ours, text().size()), text());
}

// Catches an emulated line that works at any baud rate of the client.
TEST(PtyUart, AClientAtAnotherRateReadsAndSendsGarbage) {
  PtyUart ours(kLink, 230400);
  hal::SerialPort client(kLink, 115200);
  ASSERT_EQ(client.open(), core::Status::kOk);
  EXPECT_EQ(ours.clients_baud(), 115200U);
  EXPECT_EQ(ours.write(text()).value_or(0), text().size());
  // A byte sent at another rate can be several bytes, or none.
  const std::vector<std::byte> heard = hal::received_at(text(), 230400, 115200);
  EXPECT_EQ(read_bytes(client, heard.size()), heard);
  EXPECT_NE(heard, text());
  EXPECT_EQ(client.write(text()).value_or(0), text().size());
  const std::vector<std::byte> answered = hal::received_at(text(), 115200, 230400);
  EXPECT_EQ(read_bytes(ours, answered.size()), answered);
}

TEST(PtyUart, WithoutARateOfItsOwnNothingIsGarbled) {
  PtyUart ours(kLink);
  hal::SerialPort client(kLink, 115200);
  ASSERT_EQ(client.open(), core::Status::kOk);
  EXPECT_EQ(ours.write(text()).value_or(0), text().size());
  EXPECT_EQ(read_bytes(client, text().size()), text());
}

}  // namespace
}  // namespace m100::sim
