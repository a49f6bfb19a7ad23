// SPDX-License-Identifier: BSD-3-Clause
#include "host_tests/property/protocol/streams.h"

#include <array>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "protocol/crc.h"

namespace m100::host_tests {
namespace {

using protocol::kStartByte;

void flip_some_bits(Bytes& bytes, std::mt19937& random) {
  const std::size_t flips = 1 + random() % 4;
  for (std::size_t i = 0; i < flips; ++i) {
    bytes[random() % bytes.size()] ^= static_cast<std::byte>(1U << (random() % 8));
  }
}

Bytes random_frame(std::mt19937& random) {
  if (random() % 4 == 0) {
    return telemetry_frame(static_cast<std::uint16_t>(random()), static_cast<std::uint16_t>(random() & 0xFFFU));
  }
  const protocol::MessageId id{static_cast<std::uint8_t>(random() % 6), static_cast<std::uint8_t>(random() % 4)};
  const bool is_ack = random() % 3 == 0;
  const std::size_t size = random() % 8 == 0 ? random() % 1000 : random() % 40;
  return make_frame({.session = static_cast<std::uint8_t>(random() % 32),
                     .is_ack = is_ack,
                     .sequence = static_cast<std::uint16_t>(random())},
                    is_ack ? nullptr : &id, random_bytes(size, random));
}

Bytes frame_in_frame(std::mt19937& random) {
  Bytes inner;
  while (inner.size() < 300) {
    append(inner, random_frame(random));
  }
  inner.resize(std::min<std::size_t>(inner.size(), protocol::kMaxDataBytes));
  return make_frame({.session = 0, .is_ack = true, .sequence = static_cast<std::uint16_t>(random())}, nullptr, inner);
}

Bytes false_header(std::mt19937& random) {
  constexpr std::array<std::size_t, 8> kLengths{0, 5, 11, 12, 14, 15, 16, 1023};
  const std::size_t length = random() % 2 == 0 ? kLengths[random() % kLengths.size()] : random() % 1024;
  return header(length, static_cast<std::uint8_t>(random()), static_cast<std::uint8_t>(random()),
                static_cast<std::uint16_t>(random()));
}

/// A frame with reserved bits set and matching checksums.
Bytes of_another_version(Bytes frame, std::mt19937& random) {
  constexpr std::array<std::pair<std::size_t, unsigned>, 4> kFixed{{{2, 0xFC}, {3, 0xC0}, {5, 0xFF}, {7, 0xFF}}};
  const auto [place, bits] = kFixed.at(random() % kFixed.size());
  frame.at(place) |= static_cast<std::byte>(bits & random());
  const std::uint16_t header_crc = protocol::crc16(std::span(frame).first(10));
  std::memcpy(&frame[10], &header_crc, sizeof(header_crc));
  if (frame.size() > protocol::kHeaderBytes) {
    const std::uint32_t frame_crc = protocol::crc32(std::span(frame).first(frame.size() - 4));
    std::memcpy(&frame[frame.size() - 4], &frame_crc, sizeof(frame_crc));
  }
  return frame;
}

}  // namespace

Bytes make_frame(const protocol::Envelope& envelope, const protocol::MessageId* id, std::span<const std::byte> value,
                 const protocol::Cipher* cipher) {
  std::array<std::byte, protocol::kMaxFrameBytes> space;
  const auto frame = encode_frame(envelope, id, value, space, cipher);
  if (!frame) {
    throw std::logic_error("cannot encode the frame");
  }
  return {frame->begin(), frame->end()};
}

Bytes telemetry_frame(std::uint16_t number, std::uint16_t items) {
  const auto value = static_cast<float>(number);
  protocol::Telemetry telemetry;
  telemetry.items = items;
  telemetry.time = {.ticks = 4U * number, .nanoseconds = number, .sync = 0};
  telemetry.attitude = {0.8F, 0.6F * value / 65536.F, 0.1F, -0.2F};
  telemetry.acceleration = {value, -value, 9.81F};
  telemetry.velocity_ned_m_s = {1.F / (1.F + value), 2.F, -3.F};
  telemetry.velocity_status = 1;
  telemetry.angular_velocity_frd_rad_s = {0.1F, 0.2F * value, 0.3F};
  telemetry.position = {
      .latitude_rad = 0.8 + 1e-6 * number, .longitude_rad = 0.1, .altitude_m = value, .height_m = 2.F, .gps_health = 5};
  telemetry.magnetometer = {static_cast<std::int16_t>(number), 2, -3};
  telemetry.rc = {.roll = 1, .pitch = -2, .yaw = 3, .throttle = -4, .mode = 8000, .gear = -4545};
  telemetry.gimbal = {.roll_deg = value, .pitch_deg = 1.F, .yaw_deg = 2.F, .limits = 1};
  telemetry.flight_status = protocol::FlightStatus::kInAir;
  telemetry.battery_percent = 80;
  telemetry.control = {.mode = 2, .bits = 2};
  const protocol::MessageId id = id_of(telemetry);
  return make_frame({.sequence = number}, &id, encode(telemetry));
}

Bytes header(std::size_t length, std::uint8_t session, std::uint8_t cipher_byte, std::uint16_t sequence) {
  Bytes bytes(protocol::kHeaderBytes);
  protocol::ByteWriter writer(bytes);
  writer.put(std::to_integer<std::uint8_t>(kStartByte));
  writer.put(static_cast<std::uint16_t>(length & 0x3FFU));
  writer.put(static_cast<std::uint8_t>(session & 0x3FU));
  writer.put(cipher_byte);
  writer.put(std::array<std::uint8_t, 3>{});
  writer.put(sequence);
  writer.put(protocol::crc16(writer.written()));
  return bytes;
}

Bytes random_bytes(std::size_t count, std::mt19937& random) {
  Bytes bytes(count);
  for (std::byte& byte : bytes) {
    byte = static_cast<std::byte>(random() & 0xFFU);
  }
  return bytes;
}

Bytes clean_telemetry(std::size_t count) {
  Bytes stream;
  for (std::uint16_t number = 0; stream.size() < count; ++number) {
    append(stream, telemetry_frame(number));
  }
  return stream;
}

Bytes noise(std::size_t count) {
  std::mt19937 random(1);
  return random_bytes(count, random);
}

Bytes start_bytes(std::size_t count) { return Bytes(count, kStartByte); }

Bytes longest_headers(std::size_t count) {
  Bytes stream;
  for (std::uint16_t number = 0; stream.size() < count; ++number) {
    append(stream, header(protocol::kMaxFrameBytes, 0, 0, number));
  }
  return stream;
}

Bytes frames_behind_false_headers(std::size_t count) {
  Bytes stream;
  for (std::uint16_t number = 0; stream.size() < count; ++number) {
    append(stream, header(protocol::kMaxFrameBytes, 0, 0, number));
    append(stream, telemetry_frame(number));
  }
  return stream;
}

Bytes damaged_stream(std::size_t pieces, std::mt19937& random) {
  Bytes stream;
  for (std::size_t i = 0; i < pieces; ++i) {
    Bytes piece = random_frame(random);
    switch (random() % 12) {
      case 0:
        piece = random_bytes(random() % 60, random);
        break;
      case 1:
        piece.resize(random() % piece.size());
        break;
      case 2:
        flip_some_bits(piece, random);
        break;
      case 3:
        piece = false_header(random);
        break;
      case 4:
        piece.assign(random() % 40, kStartByte);
        break;
      case 5:
        piece = frame_in_frame(random);
        break;
      case 6:
        piece = densest_headers(8 + random() % 200, static_cast<unsigned>(random() % 16));
        break;
      case 7:
        piece = of_another_version(piece, random);
        break;
      default:
        break;
    }
    append(stream, piece);
  }
  return stream;
}

}  // namespace m100::host_tests
