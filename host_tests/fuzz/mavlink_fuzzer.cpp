// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer's entry points for MAVLink. Noise alone never passes a checksum, so the mutator repairs them.
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <random>
#include <type_traits>
#include <variant>
#include <vector>

#include "firmware/companion/room/mission_transfer.h"
#include "host_tests/lab/bridge/plain_pose.h"
#include "host_tests/lab/bridge/vrpn.h"
#include "host_tests/property/mavlink/noise.h"
#include "protocol/mavlink/messages.h"
#include "protocol/mavlink/parser.h"
#include "protocol/mavlink/signature.h"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace {

using namespace m100::mavlink;

using m100::companion::MissionTransfer;
using m100::companion::Request;
using m100::companion::RequestMessage;

/// What a stranger with the key could ask of the vehicle's end of the mission protocol.
template <typename... Message>
void ask(MissionTransfer& transfer, const FrameView& frame, m100::core::TimePoint now,
         std::type_identity<std::variant<Message...>>) {
  m100::companion::Replies replies;
  const auto try_one = [&]<typename One>() {
    if (is<One>(frame)) {
      transfer.hear(Request{decode<One>(frame), frame.from}, frame.sequence % 4 == 0, now, replies);
    }
  };
  (try_one.template operator()<Message>(), ...);
  transfer.tick(now, replies);
  const auto is_sound = [](const MissionItemInt& item) {
    return m100::companion::judge(item) == m100::companion::mission_result::kAccepted;
  };
  if (!std::ranges::all_of(transfer.items(), is_sound) || transfer.items().size() > MissionTransfer::kMostItems) {
    __builtin_trap();  // what cannot be flown is in the list
  }
}

std::vector<std::uint64_t> receive(std::span<const std::byte> stream, std::size_t portion) {
  Parser parser;
  ReplayGuard guard;
  MissionTransfer transfer;
  m100::core::TimePoint now{};
  std::vector<std::uint64_t> found;
  while (!stream.empty()) {
    const std::span<const std::byte> piece = stream.first(std::min(portion, stream.size()));
    stream = stream.subspan(piece.size());
    parser.consume(piece, [&](const FrameView& frame) {
      found.push_back(frame.offset);
      now += std::chrono::milliseconds(frame.sequence);
      ask(transfer, frame, now, std::type_identity<RequestMessage>{});
      for_each_message([&]<typename Message>() {
        if (is<Message>(frame)) {
          const Frame again = encode(decode<Message>(frame), frame.from, frame.sequence);
          Parser second;
          if (second.push(again.bytes()) != again.size || !second.poll()) {
            __builtin_trap();  // what was read cannot be written
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

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) {
    return 0;
  }
  const auto stream = std::as_bytes(std::span(data, size)).subspan(1);
  if (const auto pose = m100::lab::bridge::parse_packet(stream)) {
    const AttPosMocap message = message_of(*pose, m100::lab::bridge::Axes::kEnu, 0);
    if (!(message.x * message.x <= 1e6F && message.q[0] * message.q[0] <= 1.1F)) {
      __builtin_trap();  // what is no pose was read
    }
  }
  m100::lab::bridge::VrpnStream vrpn("", 0);
  (void)vrpn.consume(m100::lab::bridge::vrpn_cookie(), [](const auto&) {});
  (void)vrpn.consume(stream, [](const auto& pose) {
    if (!is_believable(pose)) {
      __builtin_trap();
    }
  });
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
  const auto stream = std::as_writable_bytes(std::span(data, size)).subspan(1);  // byte 0 is the size of portions
  if (random() % 4 == 0) {
    stream[random() % stream.size()] = kStart2;
  }
  if (random() % 8 != 0) {
    m100::host_tests::repair_mavlink(stream, (std::uint64_t{random()} << 32U) | random());
  }
  return size;
}
