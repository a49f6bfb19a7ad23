// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer's entry points for MAVLink. Random bytes never pass a checksum, so the mutator repairs them.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include "host_tests/lab/bridge/plain_pose.h"
#include "host_tests/lab/bridge/vrpn.h"
#include "host_tests/property/mavlink/noise.h"
#include "host_tests/unit/lab/vrpn_stand_in.h"
#include "protocol/mavlink/messages.h"
#include "protocol/mavlink/parser.h"
#include "protocol/mavlink/signature.h"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace {

using namespace m100::mavlink;

std::vector<std::uint64_t> receive(std::span<const std::byte> stream, std::size_t portion) {
  Parser parser;
  ReplayGuard guard;
  std::vector<std::uint64_t> found;
  while (!stream.empty()) {
    const std::span<const std::byte> piece = stream.first(std::min(portion, stream.size()));
    stream = stream.subspan(piece.size());
    parser.consume(piece, [&](const FrameView& frame) {
      found.push_back(frame.offset);
      for_each_message([&]<typename Message>() {
        if (is<Message>(frame)) {
          const Frame again = encode(decode<Message>(frame), frame.from, frame.sequence);
          Parser second;
          if (second.push(again.bytes()) != again.size || !second.poll()) {
            __builtin_trap();  // a message that was read cannot be written
          }
        }
      });
      if (frame.is_signed) {
        (void)is_signed_with(frame, Key{});
        (void)guard.accept(frame.from, signature_of(frame), 0);
      }
    });
  }
  return found;
}

/// Checks a pose by other conditions than the reader's: a copy of the reader's check could not find it wrong.
void must_be_a_pose(const m100::lab::bridge::PlainPose& pose) {
  const auto& q = pose.body_to_world;
  const double length2 = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
  const double far2_m2 = pose.position_m.squaredNorm();
  if (!(length2 > 0.97 && length2 < 1.03 && far2_m2 < 3.1e6 && pose.t_s >= 0.0)) {
    __builtin_trap();  // something that is not a pose was accepted
  }
}

/// Reads the input twice: as a server's whole stream after its cookie, and with its first bytes as the numbers in a
/// pose of the named tracker. The second is needed because no mutation of a whole stream finds three messages that
/// belong together.
void read_vrpn(std::span<const std::byte> stream) {
  m100::lab::bridge::VrpnStream whole("", 0);
  (void)whole.consume(m100::lab::bridge::vrpn_cookie(), must_be_a_pose);
  (void)whole.consume(stream, must_be_a_pose);
  m100::lab::bridge::VrpnStandIn server;
  server.cookie();
  server.name(-1, 0, "m100");
  server.name(-2, 0, "vrpn_Tracker Pos_Quat");
  // Each byte becomes a number: 0 to 2 in steps of 1/64, a power of two up to 2^127, or NaN.
  std::array<double, 7> numbers{};
  for (std::size_t i = 0; i < numbers.size() && i < stream.size(); ++i) {
    const int byte = std::to_integer<std::int8_t>(stream[i]);
    numbers[i] = byte == -128 ? std::numeric_limits<double>::quiet_NaN() : byte < 0 ? std::exp2(-byte) : byte / 64.0;
  }
  const double t_s = stream.empty() ? 0.0 : std::to_integer<std::int8_t>(stream.back());
  server.pose(0, 0, 0, t_s, {numbers[0], numbers[1], numbers[2]}, {numbers[3], numbers[4], numbers[5], numbers[6]});
  m100::lab::bridge::VrpnStream named("m100", 0);
  (void)named.consume(server.bytes, must_be_a_pose);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) {
    return 0;
  }
  const auto stream = std::as_bytes(std::span(data, size)).subspan(1);
  if (const auto pose = m100::lab::bridge::parse_packet(stream)) {
    const AttPosMocap message = message_of(*pose, m100::lab::bridge::Axes::kEnu, 0);
    if (!(message.x * message.x <= 1e6F && message.q[0] * message.q[0] <= 1.1F)) {
      __builtin_trap();  // something that is not a pose was accepted
    }
  }
  read_vrpn(stream);
  if (receive(stream, 1 + data[0]) != receive(stream, stream.size())) {
    __builtin_trap();  // the frames depend on how the stream was cut
  }
  return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned int seed) {
  std::mt19937 random(seed);
  size = LLVMFuzzerMutate(data, size, max_size);
  if (size < 2) {
    return size;
  }
  const auto stream = std::as_writable_bytes(std::span(data, size)).subspan(1);  // byte 0 sets the size of the portions
  if (random() % 4 == 0) {
    stream[random() % stream.size()] = kStart2;
  }
  if (random() % 8 != 0) {
    m100::host_tests::repair_mavlink(stream, (std::uint64_t{random()} << 32U) | random());
  }
  return size;
}
